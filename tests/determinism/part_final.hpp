// All that a run with parts ends in, compared bit for bit: other ways of running, a resume.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

#include "tests/determinism/scenes.hpp"
#include "tests/determinism/variants.hpp"
#include "tests/part_values.hpp"

namespace talus::determinism {

struct Final {
  std::uint64_t hash;
  std::vector<double> values;
  std::string bytes;
  bool operator==(const Final&) const = default;
};

inline Final final_of(const Simulation& sim) {
  Final f{sim.state_hash(), {}, checkpoint_bytes(sim)};
  for (const PartValue& v : sim.part_values()) f.values.push_back(v.value);
  return f;
}

/// Other policies, K, threads, chunks and instruction sets end in the same as a run that ended in `wanted`.
inline void expect_same_in_other_ways(const Scene& s, std::int64_t steps, const Final& wanted) {
  for (const Variant& way :
       {Variant{ListPolicy::paper, 10, 2, 64, Isa::sse2}, Variant{ListPolicy::always, 0, 3, 257, Isa::scalar},
        Variant{ListPolicy::two_largest, 200, 2, 100, Isa::avx2},
        Variant{ListPolicy::outer_inner, 100, 8, 64, Isa::automatic}}) {
    Simulation sim(way.apply(s), way.options());
    sim.run(steps);
    EXPECT_TRUE(final_of(sim) == wanted) << s.title << ": " << way.text();
  }
}

/// A run that is saved after each of `places` and goes on with other chunks ends in the same as one without a stop.
inline void expect_same_after_resume(const Scene& s, std::int64_t steps, const std::vector<std::int64_t>& places) {
  RunOptions o;
  o.threads = 2;
  Simulation whole(s, o);
  whole.run(steps);
  for (const std::int64_t at : places) {
    const std::string path = temporary_file("part.checkpoint");
    {
      Simulation half(s, o);
      half.run(at);
      CheckpointWriter out;
      half.save(out);
      out.commit(path);
    }
    RunOptions other = o;
    other.chunk = 64;
    Simulation rest(s, other, CheckpointReader(path));
    rest.run(steps - at);
    EXPECT_TRUE(final_of(rest) == final_of(whole)) << at;
  }
}

}  // namespace talus::determinism
