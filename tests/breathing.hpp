// A part that changes the sizes of grains, for tests of lists and trajectories under changing radii. Who includes it:
// tests/determinism, tests/stability.
#pragma once

#include <algorithm>
#include <memory>
#include <string>

#include "scheduler/step/access.hpp"

namespace talus {

/// A third of the grains grows by `growth` in `steps` steps, a third shrinks by as much, the rest stays. Density stays.
/// Bodies go by the row that leads them.
class Breathing final : public Part {
 public:
  Breathing(double growth, std::int64_t steps, ParticleId leaves = -1)
      : growth_(growth), steps_(static_cast<double>(steps)), leaves_(leaves) {}
  std::string name() const override { return "breathing"; }
  bool resizes() const override { return true; }
  void sizes(const PartView& w, const Chunk&, const RowSizes& s) const override {
    for (Row i = s.lo; i < s.hi; ++i) {
      const ParticleId id = w.rows.id[i];
      if (id % 3 == 2) continue;
      const double g = id % 3 == 0 ? growth_ : -growth_, n = static_cast<double>(w.clock.step);
      const double x = (1 + g * (n + 1) / steps_) / (1 + g * n / steps_);
      s.radius[i - s.lo] *= x;
      s.mass[i - s.lo] *= x * x * x;
      if (id == leaves_ && w.clock.step == 20) s.radius[i - s.lo] = 0;
    }
  }

 private:
  double growth_, steps_;
  ParticleId leaves_;
};

inline void breathe(Simulation& sim, double growth, std::int64_t steps, ParticleId leaves = -1) {
  World& w = EngineAccess::world(sim);
  w.parts.all.push_back(std::make_unique<Breathing>(growth, steps, leaves));
  w.rows.resized = true;
  w.rows.bodies.resized = w.rows.bodies.in;
  w.rows.bodies.size2 = w.rows.bodies.size;
  if (!w.rules.has.energies) return;
  w.ledger.count_sizes(w.rows.columns);
  set_particle_capacity(w.rows, w.rows.n);
  for (Column<double>* c : {&w.ledger.push, &w.ledger.grown, &w.ledger.spare}) std::fill(c->begin(), c->end(), 0.0);
}

}  // namespace talus
