// Collects node times, and turns them into profile and Chrome trace; see profile.hpp.
#include "scheduler/team/profile.hpp"

#include <fmt/format.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <fstream>

#include "core/base/error.hpp"

namespace talus {

NodeTimer::NodeTimer(NodeTimes& times, int chunk, Node node)
    : all_(times), times_(times.mine()), chunk_(chunk), node_(node), timed_(Timed::node) {
  if (times_ == nullptr) return;
  if (chunk_ < 0) {
    outer_ = times.serial;
    times.serial = {node, 0};
  }
  outer_children_ = times_->children;
  times_->children = 0;
  begin_ = __rdtsc();
  if (chunk_ >= 0 && chunk_ == times_->last_chunk) {
    times_->hop_ticks += begin_ - times_->last_end;
    ++times_->hops;
  }
}

NodeTimer::NodeTimer(NodeTimes& times, Timed timed, int block)
    : all_(times), times_(times.mine()), chunk_(block), node_(times.serial.node), timed_(timed) {
  if (node_ == Node{-1}) times_ = nullptr;  // an observation between two runs
  if (times_ == nullptr) return;
  if (timed == Timed::loop) ++times.serial.loops;
  outer_children_ = times_->children;
  times_->children = 0;
  begin_ = __rdtsc();
}

NodeTimer::~NodeTimer() {
  if (times_ == nullptr) return;
  ThreadTimes& t = *times_;
  const std::uint64_t end = __rdtsc();
  const std::uint64_t all = end - begin_, own = all - t.children;
  t.children = outer_children_ + all;
  ++t.timers;
  if (timed_ == Timed::loop) {
    t.waiting += own;
    return;
  }
  const int k = static_cast<int>(node_);
  t.ticks[k] += own;
  if (timed_ == Timed::node) {
    ++t.calls[k];
    if (chunk_ < 0) all_.serial = outer_;
    // the next node of this chunk is ready now: until it starts, only the scheduler works. Another step's does not
    // count.
    t.last_chunk = node_ == Node::integrate ? -1 : chunk_;
    t.last_end = end;
  }
  if (all_.tracing(all_.step))
    t.trace.push_back({all_.step, begin_, end, chunk_, timed_ == Timed::block ? all_.serial.loops : 0, node_});
}

void NodeTimes::prepare(int threads) {
  threads_ = std::vector<ThreadTimes>(static_cast<std::size_t>(threads));
  zero_ = std::chrono::steady_clock::now();
  zero_ticks_ = __rdtsc();
}

void NodeTimes::restart() {
  for (ThreadTimes& t : threads_) {
    ThreadTimes fresh;
    fresh.trace = std::move(t.trace);
    t = std::move(fresh);
  }
  wall_ = 0;
  steps_ = 0;
}

void NodeTimes::trace(std::int64_t first_step, std::int64_t steps) noexcept {
  trace_from_ = first_step;
  trace_until_ = first_step + steps;
}

void NodeTimes::run_begins() noexcept {
  running_ = true;
  run_begin_ = __rdtsc();
}

void NodeTimes::run_ends(std::int64_t steps) noexcept {
  wall_ += __rdtsc() - run_begin_;
  steps_ += steps;
  running_ = false;
}

ThreadTimes* NodeTimes::mine() noexcept {
  if (!running_) return nullptr;
  const int slot = tbb::this_task_arena::current_thread_index();
  return slot >= 0 && static_cast<std::size_t>(slot) < threads_.size() ? &threads_[static_cast<std::size_t>(slot)]
                                                                       : nullptr;
}

double NodeTimes::seconds_per_tick() const {
  const std::uint64_t ticks = __rdtsc() - zero_ticks_;
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - zero_).count() / static_cast<double>(ticks);
}

std::uint64_t NodeTimes::ticks(Node node) const noexcept {
  std::uint64_t sum = 0;
  for (const ThreadTimes& t : threads_) sum += t.ticks[static_cast<int>(node)];
  return sum;
}

Profile NodeTimes::report() const {
  const double scale = seconds_per_tick();
  Profile p;
  p.wall = scale * static_cast<double>(wall_);
  p.steps = steps_;
  std::int64_t hops = 0;
  std::uint64_t hop_ticks = 0;
  for (const ThreadTimes& t : threads_) {
    Profile::Thread out;
    for (const std::uint64_t ticks : t.ticks) out.busy += scale * static_cast<double>(ticks);
    out.waiting = scale * static_cast<double>(t.waiting);
    out.idle = p.wall - out.busy - out.waiting;
    p.threads.push_back(out);
    hops += t.hops;
    hop_ticks += t.hop_ticks;
    p.clock_reads += 2 * t.timers;
    for (const Node n : {Node::narrow_phase, Node::contact_force, Node::wall_contact, Node::integrate})
      p.tasks += t.calls[static_cast<int>(n)];
  }
  p.hop = hops > 0 ? scale * static_cast<double>(hop_ticks) / static_cast<double>(hops) : 0;
  for (int k = 0; k < static_cast<int>(names.size()); ++k) {
    NodeTime row;
    row.node = names[static_cast<std::size_t>(k)];
    double largest = 0;
    for (const ThreadTimes& t : threads_) {
      const double seconds = scale * static_cast<double>(t.ticks[k]);
      row.calls += t.calls[k];
      row.seconds += seconds;
      largest = std::max(largest, seconds);
    }
    if (row.calls == 0) continue;
    if (row.seconds > 0) row.imbalance = largest * static_cast<double>(threads_.size()) / row.seconds;
    p.nodes.push_back(row);
  }
  static constexpr int reads = 2000;
  const std::uint64_t begin = __rdtsc();
  std::uint64_t last = begin;
  for (int k = 0; k < reads; ++k) last = __rdtsc();
  p.clock_read = scale * static_cast<double>(last - begin) / reads;
  return p;
}

void NodeTimes::write(const std::string& path, const std::vector<std::pair<std::string, std::string>>& facts) const {
  const double microseconds = 1e6 * seconds_per_tick();
  std::ofstream out(path);
  out << "{\"otherData\":{";
  for (std::size_t k = 0; k < facts.size(); ++k)
    out << fmt::format("{}\"{}\":{}", k == 0 ? "" : ",", facts[k].first, facts[k].second);
  out << "},\n\"traceEvents\":[\n{\"ph\":\"M\",\"pid\":1,\"name\":\"process_name\",\"args\":{\"name\":\"talus\"}}";
  std::uint64_t first = ~std::uint64_t{0};
  for (const ThreadTimes& t : threads_)
    for (const TraceEvent& e : t.trace) first = std::min(first, e.begin);
  for (std::size_t k = 0; k < threads_.size(); ++k) {
    out << fmt::format(
        ",\n{{\"ph\":\"M\",\"pid\":1,\"tid\":{},\"name\":\"thread_name\",\"args\":{{\"name\":\"thread {}\"}}}}", k, k);
    for (const TraceEvent& e : threads_[k].trace) {
      out << fmt::format(
          ",\n{{\"ph\":\"X\",\"pid\":1,\"tid\":{},\"ts\":{:.3f},\"dur\":{:.3f},\"name\":\"{}\",\"args\":{{\"step\":{}",
          k, microseconds * static_cast<double>(e.begin - first), microseconds * static_cast<double>(e.end - e.begin),
          names[static_cast<std::size_t>(e.node)], e.step);
      if (e.loop > 0)
        out << fmt::format(",\"loop\":{},\"block\":{}", e.loop, e.chunk);
      else if (e.chunk >= 0)
        out << fmt::format(",\"chunk\":{}", e.chunk);
      out << "}}";
    }
  }
  out << "\n]}\n";
  out.close();
  if (!out) throw Error(ErrorCode::io, "cannot write the trace", path);
}

}  // namespace talus
