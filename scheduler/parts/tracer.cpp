// Part "tracer": a passive scalar c of each grain. A source gives it to its grains, contacts mix it:
//   dc_i/dt = rate * sum over the contacts of i (c_j - c_i)   [explicit Euler, step dt]
// What one grain gains its partner loses, to the bit of each term. A body that is no sphere has one value, which all
// its rows show; contacts of all its rows mix it. Meant to be read as the example of a part: a column, a pass over
// contacts, one over rows, a node at the end of the step, numbers for the time series, a ledger that a checkpoint
// keeps. Invariants: I3 (terms of a grain are added in list order, as forces are), I7 (a chunk writes its own rows of
// `next_`; the rows of a body lie in one chunk).
#include <algorithm>
#include <cstring>

#include "core/base/error.hpp"
#include "core/grains/body_shape.hpp"
#include "scheduler/part.hpp"
#include "scheduler/parts/heat_bodies.hpp"
#include "scheduler/team/pools.hpp"

namespace talus {

namespace {

constexpr std::uint64_t k_seed = 100;   // of its term in the state hash
constexpr double k_most_contacts = 24;  // of a grain: c stays between the values of its neighbours
constexpr double k_sample = 8;          // edge of a sample of the mixing index, in largest radii

class Tracer final : public Part {
 public:
  explicit Tracer(const Rules& rules) : scene_(rules.scene) {}

  std::string name() const override { return "tracer"; }

  void add_columns(Columns& columns) override {
    ColumnInfo i;
    i.name = "tracer";
    i.label = "tracer, next";
    i.unit = "-";
    i.why = "tracer.rate";
    i.saved = i.output = true;
    i.hash_seed = k_seed;
    columns.add(i, now_, &next_);
  }

  std::vector<PartNode> nodes() override {
    return {{"tracer_mixing",
             PartNode::When::contacts,
             {{"tracer", true}, {"contacts"}},
             {{"next tracer"}},
             1,
             [this](const PartView& w, const Chunk& c) { add_differences(w, c); }},
            {"tracer_rate",
             PartNode::When::rows,
             {{"tracer"}, {"next tracer"}},
             {{"next tracer"}},
             1,
             [this](const PartView& w, const Chunk& c) { advance(w, c); }},
            {"tracer_step",
             PartNode::When::step,
             {{"next tracer"}},
             {{"tracer"}},
             1,
             [this](const PartView&, const Chunk&) { std::swap(now_, next_); }}};
  }

  void appended(const Rows& rows, Row first, const NewParticles& a) override {
    for (std::size_t k = 0; k < a.size(); ++k) {
      const double c = scene_.sources[static_cast<std::size_t>(a.source[k])].tracer;
      now_[static_cast<std::size_t>(first) + k] = next_[static_cast<std::size_t>(first) + k] = c;
      if (rows.leads(first + static_cast<Row>(k))) ledger_.inserted += c;
    }
  }
  void removed(const Rows& rows, Row i) override {
    if (rows.leads(i)) ledger_.removed += now_[static_cast<std::size_t>(i)];
  }
  void take_back() override { std::swap(now_, next_); }

  /// Longer steps would let a grain of many contacts leave the range of its neighbours' values.
  double step_limit(const PartView&) const override {
    return scene_.tracer_rate > 0 ? 1 / (most_contacts() * scene_.tracer_rate) : k_never;
  }

  std::vector<PartValue> values(const PartView& w) const override {
    const double total = sum(w.rows);
    return {{"tracer.total", "-", total},
            {"tracer.residual", "-", total + ledger_.removed - ledger_.inserted},
            {"tracer.mixing_index", "-", mixing_index(w)}};
  }

  std::vector<std::uint8_t> save() const override {
    std::vector<std::uint8_t> bytes(sizeof ledger_);
    std::memcpy(bytes.data(), &ledger_, sizeof ledger_);
    return bytes;
  }
  void load(std::span<const std::uint8_t> bytes, const std::string& where) override {
    if (bytes.size() != sizeof ledger_) throw Error(ErrorCode::io, "section 'part tracer' has a wrong size", where);
    std::memcpy(&ledger_, bytes.data(), sizeof ledger_);
  }

 private:
  struct Totals {
    double inserted = 0, removed = 0;
  };

  /// Of a clump so many on each of its spheres.
  double most_contacts() const {
    std::size_t spheres = 1;
    if (makes_bodies(scene_))
      for (const ShapeSpec& s : scene_.shapes) spheres = std::max(spheres, s.body->spheres.size());
    return k_most_contacts * static_cast<double>(spheres);
  }

  void add_differences(const PartView& w, const Chunk& c) {
    const Scratch& s = *c.scratch;
    const double* now = now_.data();
    double* sum = next_.data();
    std::fill(sum + c.lo, sum + c.hi, 0.0);
    const bool superquadrics = w.rules.has.superquadrics;
    for (std::int64_t q = 0; q < c.contacts.end[2]; ++q) {
      // spheres that hold superquadrics meet before they do
      if (superquadrics && s.depth[static_cast<std::size_t>(q)] == 0) continue;
      const Row i = s.ci[static_cast<std::size_t>(q)], j = s.cj[static_cast<std::size_t>(q)];
      sum[i] = sum[i] + (now[j] - now[i]);
      if (q >= c.contacts.end[0] && q < c.contacts.end[1]) sum[j] = sum[j] + (now[i] - now[j]);  // both are its own
    }
  }

  void advance(const PartView& w, const Chunk& c) {
    const double k = w.rules.scene.dt * scene_.tracer_rate;
    if (w.rows.bodies.in) return advance_bodies(w, c, k);
    for (auto i = static_cast<std::size_t>(c.lo); i < static_cast<std::size_t>(c.hi); ++i)
      next_[i] = now_[i] + k * next_[i];
  }
  void advance_bodies(const PartView& w, const Chunk& c, double k) {
    for (Row i = c.lo; i < c.hi; ++i) {
      if (!w.rows.leads(i)) continue;
      const Row end = w.rows.is_alive(i) ? end_of_grain(w, i) : i + 1;
      double sum = 0;
      for (Row q = i; q < end; ++q) sum = sum + next_[static_cast<std::size_t>(q)];
      const double c_next = now_[static_cast<std::size_t>(i)] + k * sum;
      for (Row q = i; q < end; ++q) next_[static_cast<std::size_t>(q)] = c_next;
    }
  }

  /// Over blocks of 1024 rows (I3).
  double sum(const Rows& rows) const {
    double total = 0;
    for (Row b = 0; b < rows.n; b += 1024) {
      double part = 0;
      for (Row i = b; i < std::min<Row>(rows.n, b + 1024); ++i)
        if (rows.is_alive(i) && rows.leads(i)) part = part + now_[static_cast<std::size_t>(i)];
      total = total + part;
    }
    return total;
  }

  /// Lacey (1954): (s0^2 - s^2) / (s0^2 - sr^2), 0 unmixed, 1 mixed at random. s^2: variance of the means of samples,
  /// cells of a fixed grid, weighted by their grains; s0^2: of two unmixed parts of the sources' extreme values with
  /// the same mean; sr^2: of random samples of so many grains. 1 where all is alike.
  double mixing_index(const PartView& w) const {
    int n[3];
    for (int k = 0; k < 3; ++k) n[k] = std::max(1, static_cast<int>(w.rules.size[k] / (k_sample * w.rules.r_max)));
    struct Sample {
      double sum = 0, grains = 0;
    };
    std::vector<Sample> samples(static_cast<std::size_t>(n[0]) * static_cast<std::size_t>(n[1]) *
                                static_cast<std::size_t>(n[2]));
    Sample all;
    for (Row i = 0; i < w.rows.n; ++i) {
      if (!w.rows.is_alive(i) || !w.rows.leads(i)) continue;
      const double* x = w.rows.grain_at(i);
      int at[3];
      for (int k = 0; k < 3; ++k) at[k] = std::clamp(static_cast<int>(x[k] / w.rules.size[k] * n[k]), 0, n[k] - 1);
      Sample& s = samples[static_cast<std::size_t>((at[2] * n[1] + at[1]) * n[0] + at[0])];
      for (Sample* to : {&s, &all}) {
        to->sum += now_[static_cast<std::size_t>(i)];
        to->grains += 1;
      }
    }
    if (!(all.grains > 0)) return 1;
    const double mean = all.sum / all.grains;
    double s2 = 0, filled = 0;
    for (const Sample& s : samples) {
      if (!(s.grains > 0)) continue;
      const double off = s.sum / s.grains - mean;
      s2 += s.grains * (off * off);
      filled += 1;
    }
    double low = k_never, high = -k_never;
    for (const Source& s : scene_.sources) low = std::min(low, s.tracer), high = std::max(high, s.tracer);
    const double unmixed = (high - mean) * (mean - low), random = unmixed * filled / all.grains;
    return unmixed > random ? (unmixed - s2 / all.grains) / (unmixed - random) : 1;
  }

  const Scene& scene_;
  Column<double> now_, next_;
  Totals ledger_;
};

}  // namespace

std::unique_ptr<Part> make_tracer(const Rules& rules) {
  return rules.scene.tracer_rate >= 0 ? std::make_unique<Tracer>(rules) : nullptr;
}

}  // namespace talus
