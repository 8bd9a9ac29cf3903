// Scenes and particle files.
#include <string_view>

#include "core/error.hpp"
#include "core/io/particle_file.hpp"
#include "core/io/scene_file.hpp"
#include "tests/fuzz/targets.hpp"

namespace talus::fuzz {

namespace {

std::string_view text_of(Bytes input) { return {reinterpret_cast<const char*>(input.data()), input.size()}; }

void check(bool good) {
  if (!good) __builtin_trap();
}

/// Every message is one printable line of a bounded length.
void check_message(const Error& e) {
  const std::string_view text = e.what();
  check(!text.empty() && text.size() < 2000);
  for (const char c : text) check(static_cast<unsigned char>(c) >= 0x20 && c != 0x7f);
}

}  // namespace

void scene(Bytes input) {
  try {
    const Scene s = parse_scene(text_of(input), "fuzz.toml", "/nonexistent");
    check(s.dt > 0 && s.steps >= 0 && !s.materials.empty());
    check(s.pairs.size() == s.materials.size() * s.materials.size());
  } catch (const Error& e) {
    check_message(e);
  }
}

void particles(Bytes input) {
  Material glass;
  glass.name = "glass";
  const Material materials[] = {glass};
  try {
    const ParticleFile f = parse_particles(text_of(input), "fuzz.csv", materials);
    check(f.v.size() == f.size() && f.r.size() == f.size() && f.row.size() == f.size());
    for (std::size_t k = 0; k < f.size(); ++k) {
      check(f.r[k] > 0 && f.r[k] < 1e300);
      for (int a = 0; a < 3; ++a) check(f.x[k][a] - f.x[k][a] == 0 && f.v[k][a] - f.v[k][a] == 0);
      if (!f.material.empty()) check(f.material[k] == 0);
    }
  } catch (const Error& e) {
    check_message(e);
  }
}

}  // namespace talus::fuzz
