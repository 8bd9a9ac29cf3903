// What is fuzzed: readers of files from outside, and every kernel on every instruction set against the scalar one. Who
// calls it: replay_test.cpp (corpus and a few thousand mutations, in every test run) and libfuzzer/entry.cpp (-D
// TALUS_FUZZ=ON with clang). Invariants: a target returns for every input, an Error of the reader is a good answer;
// anything else (a crash, a hang, another exception, bits that differ) ends the process.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace talus::fuzz {

using Bytes = std::span<const std::uint8_t>;

void scene(Bytes input);       ///< text of a scene file
void particles(Bytes input);   ///< CSV or LAMMPS data file
void mesh(Bytes input);        ///< first byte: format, rest: STL, OBJ or PLY
void checkpoint(Bytes input);  ///< container; or a section of a real checkpoint in place of its own bytes
void series(Bytes input);      ///< series.csv that a run is resumed with
void kernels(Bytes input);     ///< contacts, rows and lists made from the bytes

struct Target {
  const char* name;
  void (*run)(Bytes);
};
inline constexpr Target k_targets[] = {{"scene", scene},           {"particles", particles}, {"mesh", mesh},
                                       {"checkpoint", checkpoint}, {"series", series},       {"kernels", kernels}};

}  // namespace talus::fuzz
