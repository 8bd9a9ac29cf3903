// What is fuzzed: the readers of files from outside, and the contact kernels on every instruction set and against the
// scalar oracle. Who calls it: replay_test.cpp (the corpus and some mutations of it, in every test run) and
// libfuzzer/entry.cpp (TALUS_FUZZ=ON with clang). Invariants: a target returns for every input; an Error of a reader is
// a good answer; a claim that does not hold throws Finding; anything else (a crash, a hang, another exception) ends the
// process.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>

namespace talus {
class Error;
}

namespace talus::fuzz {

using Bytes = std::span<const std::uint8_t>;

struct Finding : std::logic_error {
  using std::logic_error::logic_error;
};
inline void claim(bool holds, const char* what) {
  if (!holds) throw Finding(what);
}
/// Every message is one line of bounded length without control characters.
void check_message(const Error& e);

void scene(Bytes input);       ///< text of a scene file
void particles(Bytes input);   ///< table or LAMMPS data file
void mesh(Bytes input);        ///< first byte: format, rest: STL, OBJ or PLY
void checkpoint(Bytes input);  ///< first byte: a section of a real checkpoint to damage, or none: a file of these bytes
void series(Bytes input);      ///< series.csv as `info`, `report` and a resumed run read it
void summary(Bytes input);     ///< summary.json as `info` and `report` read it
void kernels(Bytes input);     ///< contacts, rows and lists made from the bytes: the same bits on every instruction set
void contacts(Bytes input);    ///< ordinary contacts: forces, moments and histories of the scalar oracle

struct Target {
  const char* name;
  void (*run)(Bytes);
};
inline constexpr Target k_targets[] = {{"scene", scene},     {"particles", particles}, {"mesh", mesh},
                                       {"series", series},   {"summary", summary},     {"checkpoint", checkpoint},
                                       {"kernels", kernels}, {"contacts", contacts}};

}  // namespace talus::fuzz
