// The step at a glance. One step n: check the displacements of the last drift, rebuild the list if it expired, then per
// chunk narrow phase -> contact forces -> (walls) -> integration, and join.
//
//   displacement_check --(valid)--------------------------------> start -> narrow_phase[c] --(no chunk left)--> join
//          |                                                        ^        -> contact_force[c]                 |
//          +--(expired, forced)--> insert -> sort_epoch -> rebuild -+          -> (wall_contact[c])              |
//          ^                       (insert only if the scene does)               -> integrate[c]                 |
//          |                                                                       -> (plane_count[c])           |
//          |                                                                       -> narrow_phase[the next c]   |
//          +-----------------------------------------------------------------------------------------------------+
//
// node                reads                                   writes
// displacement_check  integrate's flags and leavers           dead rows, counters
// insert              p, v, scene                             rows appended, v of events
// sort_epoch          p, v, contacts                          storage order of everything
// rebuild             p, v, v2, old lists                     x0, cells, lists, masks, history order
// narrow_phase[c]     p, list c                               mask c, history c, scratch c
// contact_force[c]    p, v, scratch c                         history c, force rows of c (scratch), energy rows of c
// wall_contact[c]     p, v, walls, force rows of c            wall history c, force rows of c
// integrate[c]        p, v, force rows of c, x0               p2, v2 rows of c, flags c
// plane_count[c]      p, p2                                   crossings c
// join                crossings, energy rows                  swaps p/p2 and v/v2, totals, n + 1
// Two unordered nodes never share a written array (I7): unordered are only nodes of different chunks.
// There are as many such loops ("lanes") as threads can work at once. narrow_phase takes the next chunk of its thread's
// share, or of another one's when that is used up (shares.hpp), so lanes balance themselves. Only narrow_phase is a
// task; the nodes behind it run within it (lightweight). With a task for every node and chunk the scheduler took 0.38
// us per chunk of one thread instead of 0.22, and on many threads all of them met in one join.
// A lane without chunks reports to the join and waits for the next step in place (step_gate.hpp), unless that begins
// with a rebuild: then, and for any other loop over chunks, the threads are sent away and start hands out all lanes.
#include <oneapi/tbb/flow_graph.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <deque>

#include "core/base/det_math.hpp"
#include "core/base/error.hpp"
#include "core/grains/region.hpp"
#include "scheduler/step/world.hpp"
#include "scheduler/team/available_cores.hpp"
#include "scheduler/team/parallel.hpp"

namespace talus {

namespace {

/// The wall time of a run for the profile, also when it fails.
class TimedRun {
 public:
  explicit TimedRun(World& w) : w_(w), first_(w.step) { w_.times.run_begins(); }
  ~TimedRun() { w_.times.run_ends(w_.step - first_); }
  TimedRun(const TimedRun&) = delete;
  TimedRun& operator=(const TimedRun&) = delete;

 private:
  World& w_;
  std::int64_t first_;
};

/// One of the loops over chunks of the step graph, and the chunk that it works on.
struct alignas(128) Lane {
  int index;
  Chunk* chunk = nullptr;
};

int lanes_of(const World& w) {
  return std::max(1, std::min(w.lane_choice.threads(), static_cast<int>(w.chunks.size())));
}

std::string at_step(const World& w) { return "step " + std::to_string(w.step); }

/// Runs a node's body; exceptions do not cross TBB: the failure of the lowest chunk is kept and rethrown after the
/// wait.
template <class F>
void guarded(World& w, int chunk, F body) {
  if (w.failed.load(std::memory_order_relaxed)) return;
  try {
    body();
  } catch (...) {
    const std::lock_guard<std::mutex> lock(w.error_mutex);
    if (!w.error || chunk < w.error_chunk) {
      w.error = std::current_exception();
      w.error_chunk = chunk;
    }
    w.failed.store(true);
  }
}

ListRecord list_record(const World& w) {
  ListRecord r;
  r.step = w.step;
  r.interval = w.step - w.last_rebuild_step;
  r.k = w.skin.has_k() ? w.skin.k_dt / w.scene.dt : 0;
  r.floor = w.skin.floor_on ? w.skin.floor : 0;
  r.skin = w.frame.mean_skin;
  r.pairs = w.counters.pairs;
  std::int64_t twice = 0;
  for (const auto& c : w.chunks)
    twice += 2 * (c->contact_end[1] - c->contact_end[0]) + c->contact_end[0] + (c->contact_end[2] - c->contact_end[1]);
  r.contacts = twice / 2;
  return r;
}

/// Failures and leavers of the last integration, in chunk order.
void collect_results(World& w) {
  if (!w.news.load(std::memory_order_relaxed)) return;
  static const char* const axis = "xyz";
  for (const auto& cp : w.chunks) {
    Chunk& c = *cp;
    // made only on failure: formatted for every chunk of every step it was most of the serial check
    const auto too_deep = [&w] {
      return " overlap by more than " + std::to_string(w.scene.max_overlap) + " of the smaller radius";
    };
    const char* const deep_cure =
        "stiffer contacts, a smaller time step, relax.steps for an overlapping start, or a larger checks.max_overlap";
    if (c.deep_slot >= 0) {
      const ParticleId i = w.id[c.row_buffer[0]], j = w.id[c.row_buffer[1]];
      fail_step(w, {i, j}, "particles " + std::to_string(i) + " and " + std::to_string(j) + too_deep(), deep_cure);
    }
    if (c.deep_wall >= 0) {
      const WallState& t = c.wall_state[static_cast<std::size_t>(c.deep_wall)];
      fail_step(
          w, {w.id[t.row]},
          "particle " + std::to_string(w.id[t.row]) + " and wall '" + w.walls.name(t.contact.wall) + "'" + too_deep(),
          deep_cure);
    }
    if (c.unstable_row >= 0)
      fail_step(w, {w.id[c.unstable_row]},
                "particle " + std::to_string(w.id[c.unstable_row]) +
                    ": the stiffness of its contacts makes the time step unstable",
                "a smaller time.step");
    for (std::int32_t k = 0; k < c.out_count; ++k)
      if (const Row i = c.out[static_cast<std::size_t>(k)]; !finite_row(w, i)) fail_non_finite(w, i);
  }
  judge_step(w);
  for (const auto& cp : w.chunks) {
    Chunk& c = *cp;
    for (std::int32_t k = 0; k < c.out_count; ++k) {
      const Row i = c.out[static_cast<std::size_t>(k)];
      const double* x = w.p.data() + 4L * i;
      for (int a = 0; a < 3; ++a) {
        if (w.scene.domain.periodic(a) || (x[a] >= 0 && x[a] < w.size[a])) continue;
        if (w.scene.domain.boundary[static_cast<std::size_t>(a)][x[a] < 0 ? 0 : 1] != Boundary::open) {
          const Vec3 at = w.position(i);
          w.culprits = {w.id[i]};
          throw Error(ErrorCode::physics,
                      "particle " + std::to_string(w.id[i]) + " left the domain through the closed " + axis[a] +
                          " side at (" + std::to_string(at.x) + ", " + std::to_string(at.y) + ", " +
                          std::to_string(at.z) + ")",
                      at_step(w), "a smaller time.step, stiffer walls, or an open boundary there");
        }
      }
      remove_row(w, i);
    }
    c.out_count = 0;
  }
  w.news.store(false, std::memory_order_relaxed);
}

}  // namespace

Decision check_step(World& w, std::int64_t target) {
  NodeTimer timer(w, w.serial, Node::displacement_check);
  Decision d;
  collect_results(w);
  if (w.step >= target) {
    d.stop = true;
    return d;
  }
  w.law_args.start = w.step == 0 ? 1 : 0;
  if (w.has.walls) w.walls.set_step(w.step, w.scene.dt);
  if (w.has.moving_walls) judge_walls(w);
  const bool insertion = w.has.insertion && w.insertion->next_step(w.step) == w.step;
  const bool event =
      w.next_event < w.scene.events.size() && det::nearest(w.scene.events[w.next_event].time / w.scene.dt) <= w.step;
  const bool epoch = w.step % w.scene.sort_every == 0;
  d.structure = w.structure = insertion || event || epoch;
  w.sampled =
      w.step >= w.scene.relax.steps && (d.structure || w.step % k_sample_every == 0 || w.step == w.scene.relax.steps);
  d.rebuild = d.structure || !w.lists_valid || lists_expired(w);
  return d;
}

namespace {

/// Particles due at this step. A pack that finds no room ends a run that has come this far, not the scene.
NewParticles batch_of(World& w) {
  const PresentParticles present{std::span<const double>(w.p.data(), 4L * static_cast<std::size_t>(w.n))};
  try {
    return w.insertion->batch(w.step, present, &w.walls);
  } catch (const Error& e) {
    throw Error(ErrorCode::physics, e.what(), "step " + std::to_string(w.step));
  }
}

}  // namespace

void insert_step(World& w) {
  NodeTimer timer(w, w.serial, Node::insert);
  for (; w.next_event < w.scene.events.size(); ++w.next_event) {
    const Event& e = w.scene.events[w.next_event];
    if (det::nearest(e.time / w.scene.dt) > w.step) break;
    if (e.action == Event::Action::gravity) {
      double energy = 0;
      if (w.has.energies)
        for (Row i = 0; i < w.n; ++i)
          if (w.is_alive(i)) energy -= w.row_energy(i);
      w.gravity = e.vector;
      if (w.has.energies)
        for (Row i = 0; i < w.n; ++i)
          if (w.is_alive(i)) energy += w.row_energy(i);
      w.inserted_energy += energy;
      continue;
    }
    for (Row i = 0; i < w.n; ++i) {
      if (!w.is_alive(i)) continue;
      if (e.group >= 0) {
        const GroupSpec& g = w.scene.groups[static_cast<std::size_t>(e.group)];
        bool in = w.group[i] == e.group;
        if (g.fixed_in_file && w.fixed[i] != 0) in = true;
        if (g.ids && w.id[i] >= (*g.ids)[0] && w.id[i] <= (*g.ids)[1]) in = true;
        if (g.region) in = in || inside(w.scene.domain, *g.region, w.position(i));
        if (!in) continue;
      }
      double* v = w.v.data() + static_cast<long>(w.stride) * i;
      const double r = w.p[4L * i + 3], energy = w.has.energies ? w.row_energy(i) : 0;
      const auto set_motion = [&](Vec3 velocity, Vec3 spin) {
        for (int k = 0; k < 3; ++k) v[k] = velocity[k];
        if (w.has.rotation)
          for (int k = 0; k < 3; ++k) v[4 + k] = r * spin[k];
      };
      switch (e.action) {
        case Event::Action::freeze:
          set_motion({}, {});
          v[w.stride - 1] = 0;
          w.fixed[i] = 1;
          break;
        case Event::Action::drive:
          set_motion(e.vector, e.spin);
          v[w.stride - 1] = 0;
          w.fixed[i] = 1;
          break;
        case Event::Action::release:
          if (!w.has.fixed) break;  // nothing was ever held: there is no such column
          v[w.stride - 1] = 1.0 / w.mass(i);
          w.fixed[i] = 0;
          break;
        case Event::Action::set_velocity:
          set_motion(e.vector, e.spin);
          break;
        case Event::Action::remove:
          remove_row(w, i);
          break;
        case Event::Action::gravity:
          break;
      }
      if (w.has.energies && e.action != Event::Action::remove) w.inserted_energy += w.row_energy(i) - energy;
    }
  }
  if (w.has.insertion && w.insertion->next_step(w.step) == w.step) {
    const NewParticles a = batch_of(w);
    warn_of_shortfalls(w);
    if (a.size() > 0) {
      append_particles(w, a, false);
      w.counters.inserted += static_cast<std::int64_t>(a.size());
      w.velocity_at_old_step = false;
      make_chunks(w);  // rows of existing chunks do not move; their lists are carried by the rebuild that follows
    }
  }
}

void sort_step(World& w) {
  if (w.step % w.scene.sort_every != 0) return;
  NodeTimer timer(w, w.serial, Node::sort_epoch);
  check_finite(w);
  w.tuner.interval_ends(w);
  note_displacements(w);
  sort_epoch(w);
  rebuild_step(w, true);
}

void rebuild_step(World& w, bool forced) {
  NodeTimer timer(w, w.serial, Node::rebuild);
  const bool cut = rebuild_tuned(w, !forced);
  w.list_series.add(list_record(w));
  w.lists_valid = true;
  if (cut) {
    w.last_rebuild_step = w.step;
    return;
  }
  if (forced) {
    ++w.counters.rebuilds_forced;
  } else {
    ++w.counters.rebuilds_skin;
    const std::int64_t interval = w.step - w.last_rebuild_step;
    if (w.counters.shortest_interval == 0 || interval < w.counters.shortest_interval)
      w.counters.shortest_interval = interval;
  }
  if (w.counters.interval_steps.size() < 4096) w.counters.interval_steps.push_back(w.step);
  w.last_rebuild_step = w.step;
}

namespace {

/// Terms of one block of rows: damping, friction, background, drive, gravity along periodic axes, in places 1 to 5.
StepWork work_of_rows(const World& w, Row from, Row to, Vec3 pull) {
  StepWork part{};
  const bool pulled = norm2(pull) > 0;
  for (Row i = from; i < to; ++i) {
    const double* e = w.energy.data() + 4L * i;
    for (int k = 1; k < 3; ++k) part[k] = part[k] + e[k];
    // a driven row's work, or what local damping takes from a free one
    const bool free = w.scene.local_damping != 0 && w.v[static_cast<long>(w.stride) * i + w.stride - 1] > 0;
    part[free ? 3 : 4] += e[3];
    if (pulled && w.is_alive(i)) {
      // v2 holds v(n-1/2) now: what gravity has done on the way from n-1 to n
      const double* u = w.v2.data() + static_cast<long>(w.stride) * i;
      if (u[w.stride - 1] > 0) part[5] += w.scene.dt * w.mass(i) * dot(pull, Vec3{u[0], u[1], u[2]});
    }
    if (w.scene.viscous_damping != 0 && w.is_alive(i)) {
      const double *v = w.v.data() + static_cast<long>(w.stride) * i,
                   *u = w.v2.data() + static_cast<long>(w.stride) * i;
      double q = 0, rot = 0;
      for (int k = 0; k < 3; ++k) q += u[k] * (0.5 * (u[k] + v[k]));
      if (w.has.rotation)
        for (int k = 4; k < 7; ++k) rot += u[k] * (0.5 * (u[k] + v[k]));
      if (v[w.stride - 1] > 0) part[3] += w.scene.viscous_damping * w.scene.dt * w.mass(i) * (q + 0.4 * rot);
    }
  }
  return part;
}

/// Adds the work of the finished step to the run's totals. The first step of the motion has no way behind it.
void add_step_work(World& w) {
  NodeTimer timer(w, w.serial, Node::energy);
  // fixed blocks of 1024 rows in a fixed tree: independent of chunks and threads (I3)
  const Vec3 pull = w.gravity_along(true);
  const std::int64_t count = (w.n + k_energy_block - 1) / k_energy_block;
  w.step_work.resize(static_cast<std::size_t>(count));
  const Blocks blocks{count, static_cast<int>(std::clamp<std::int64_t>(count / 8, 1, w.threads))};
  parallel(w, blocks.count, [&](int q) {
    for (std::int64_t b = blocks.from(q); b < blocks.to(q); ++b) {
      const auto from = static_cast<Row>(b * k_energy_block);
      w.step_work[static_cast<std::size_t>(b)] = work_of_rows(w, from, std::min<Row>(w.n, from + k_energy_block), pull);
    }
  });
  StepWork sum{};
  for (const StepWork& part : w.step_work)
    for (int k = 1; k < 6; ++k) sum[k] = sum[k] + part[k];
  double power = sum[4];
  if (w.has.moving_walls)
    for (const auto& c : w.chunks)
      for (const double p : c->wall_power) power += p;
  w.work_before = w.work;
  const double before = w.work.drive;
  w.work.drive = power;
  if (w.step <= w.scene.relax.steps) return;
  w.work.damping += sum[1];
  w.work.friction += sum[2];
  w.work.background += sum[3];
  w.work.gravity += sum[5];
  // energies hold at n: the trapezium rule over [n-1, n]
  w.work.wall += 0.5 * (before + power);
}

}  // namespace

void finish_step(World& w) {
  std::swap(w.p, w.p2);
  std::swap(w.v, w.v2);
  w.velocity_at_old_step = true;
  note_travel(w);
  if (w.has.energies) add_step_work(w);
  if (w.has.planes) add_crossings(w);
  const std::chrono::duration<double> now = std::chrono::steady_clock::now().time_since_epoch();
  w.lane_choice.step_done(now.count(), w.last_rebuild_step != w.step && !w.structure);
  ++w.step;
  ++w.counters.steps;
}

void run_graph(World& w, std::int64_t target) {
  using namespace tbb::flow;
  using Go = continue_msg;
  tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(w.threads));
  static const int cores = available_cores();
  bool running = true, enter_at_start = false;
  const TimedRun timed(w);
  while (running) {
    tbb::task_arena arena(w.lane_choice.threads());
    bool rebuilt = false;
    arena.execute([&] {
      graph g;
      // Typed nodes in order; a merge is a function_node (a continue_node counts predecessors), a branch a
      // multifunction_node.
      using Check = multifunction_node<Go, std::tuple<Go, Go>, lightweight>;
      Check displacement_check(g, unlimited, [&w, target](const Go&, Check::output_ports_type& ports) noexcept {
        Decision d;
        if (lanes_of(w) != w.graph_lanes && w.step < target) {  // another graph decides about this step
          w.gate.dismiss();
          return;
        }
        guarded(w, -1, [&] { d = check_step(w, target); });
        const bool stop = d.stop || w.failed.load();
        if (stop || d.rebuild) w.gate.dismiss();
        if (stop) return;
        if (d.rebuild)
          std::get<0>(ports).try_put(Go());
        else
          std::get<1>(ports).try_put(Go());
      });
      const bool inserts = w.has.insertion || w.has.events;
      function_node<Go, Go> insert(g, serial, [&w](const Go&) {
        guarded(w, -1, [&] { insert_step(w); });
        return Go();
      });
      using Narrow = multifunction_node<Go, std::tuple<Go, Go>>;
      using Rebuild = multifunction_node<Go, std::tuple<Go>>;
      Rebuild rebuild(g, serial, [&w, &rebuilt](const Go&, Rebuild::output_ports_type& ports) {
        guarded(w, -1, [&] {
          const bool epoch = w.step % w.scene.sort_every == 0;
          if (epoch)
            sort_step(w);
          else
            rebuild_step(w, !lists_expired(w));
        });
        // another number of lanes needs another graph
        if (!w.failed.load() && lanes_of(w) == w.graph_lanes)
          std::get<0>(ports).try_put(Go());
        else
          rebuilt = true;
      });
      const auto audit = [&w] {
        if (w.options.audit) w.counters.missed_contacts += audit_lists(w);
      };
      std::deque<Narrow> first;  // of every lane
      using Start = multifunction_node<Go, std::tuple<Go>, lightweight>;
      Start start(g, unlimited, [&w, &first, audit](const Go&, Start::output_ports_type& ports) noexcept {
        guarded(w, -1, audit);
        w.shares.begin_round();
        if (w.gate.dismissed()) {
          w.gate.started();
          std::get<0>(ports).try_put(Go());
        } else {
          w.gate.open([&first](std::uint16_t lane) { first[lane].try_put(Go()); });
        }
      });
      continue_node<Go, lightweight> join(g, [&w](const Go&) noexcept {
        guarded(w, -1, [&] { finish_step(w); });
        return Go();
      });
      std::deque<continue_node<Go>> forks;
      std::deque<continue_node<Go, lightweight>> inner;
      w.graph_lanes = lanes_of(w);
      w.shares.prepare(static_cast<int>(w.chunks.size()), w.lane_choice.threads());
      w.gate.prepare(w.graph_lanes, w.lane_choice.threads() <= cores);
      std::vector<Lane> lanes(static_cast<std::size_t>(w.graph_lanes));
      for (Lane& lane : lanes) {
        lane.index = static_cast<int>(&lane - lanes.data());
        const auto add = [&](void (*work)(World&, Chunk&)) -> continue_node<Go, lightweight>& {
          return inner.emplace_back(g, [&w, &lane, work](const Go&) noexcept {
            guarded(w, lane.chunk->index, [&] { work(w, *lane.chunk); });
            return Go();
          });
        };
        auto& narrow_phase =
            first.emplace_back(g, unlimited, [&w, &lane](const Go&, Narrow::output_ports_type& ports) noexcept {
              const int slot = thread_slot(w);
              int k = w.shares.take(slot);
              while (k < 0) {
                const std::uint32_t round = w.gate.round();
                std::get<1>(ports).try_put(Go());
                if (!w.gate.await(round, lane.index)) return;
                k = w.shares.take(slot);
              }
              lane.chunk = w.chunks[static_cast<std::size_t>(k)].get();
              guarded(w, k, [&] { narrow_chunk(w, *lane.chunk); });
              std::get<0>(ports).try_put(Go());
            });
        auto& contact_force = add(force_chunk);
        auto& integrate = add(integrate_chunk);
        make_edge(output_port<0>(narrow_phase), contact_force);
        if (w.has.walls) {
          auto& wall_contact = add(wall_chunk);
          make_edge(contact_force, wall_contact);
          make_edge(wall_contact, integrate);
        } else {
          make_edge(contact_force, integrate);
        }
        if (w.has.planes) {
          auto& plane_count = add(plane_chunk);
          make_edge(integrate, plane_count);
          make_edge(plane_count, narrow_phase);
        } else {
          make_edge(integrate, narrow_phase);
        }
        make_edge(output_port<1>(narrow_phase), join);
      }
      // Halving ranges hand the lanes on: a thief takes half of what is left and becomes a victim itself. With all
      // lanes in one thread's queue 27 others look for that one queue at random, 0.4 us per miss.
      const auto fan_out = [&](const auto& self, std::size_t lo, std::size_t hi) -> receiver<Go>& {
        if (hi - lo == 1) return first[lo];
        auto& half = forks.emplace_back(g, [](const Go&) { return Go(); });
        make_edge(half, self(self, lo, (lo + hi) / 2));
        make_edge(half, self(self, (lo + hi) / 2, hi));
        return half;
      };
      make_edge(output_port<0>(start), fan_out(fan_out, 0, first.size()));
      if (inserts) {
        make_edge(output_port<0>(displacement_check), insert);
        make_edge(insert, rebuild);
      } else {
        make_edge(output_port<0>(displacement_check), rebuild);
      }
      make_edge(output_port<0>(rebuild), start);
      make_edge(output_port<1>(displacement_check), start);
      make_edge(join, displacement_check);
      if (enter_at_start)
        start.try_put(Go());
      else
        displacement_check.try_put(Go());
      g.wait_for_all();
    });
    if (w.failed.load()) {
      for (const auto& c : w.chunks)
        if (c->scratch != nullptr) {
          w.scratch.give(c->scratch);
          c->scratch = nullptr;
        }
      const std::exception_ptr e = w.error;
      w.error = nullptr;
      std::rethrow_exception(e);
    }
    running = w.step < target;
    enter_at_start = running && rebuilt;  // the graph stopped between rebuild and start
  }
}

std::string graph_picture(const World& w) {
  std::string s = "displacement_check --valid--> narrow_phase[c] -> contact_force[c] -> ";
  if (w.has.walls) s += "wall_contact[c] -> ";
  s += "integrate[c] -> ";
  if (w.has.planes) s += "plane_count[c] -> ";
  s += "join -> displacement_check\n";
  s += "displacement_check --expired--> ";
  if (w.has.insertion || w.has.events) s += "insert -> ";
  s += "rebuild (sort_epoch every " + std::to_string(w.scene.sort_every) + " steps) -> narrow_phase[c]\n";
  return s;
}

}  // namespace talus
