// Scenes and particle files.
#include <string_view>

#include "core/base/error.hpp"
#include "core/tables/particle_file.hpp"
#include "core/scene/scene_file.hpp"
#include "tests/fuzz/targets.hpp"

namespace talus::fuzz {

namespace {

std::string_view text_of(Bytes input) { return {reinterpret_cast<const char*>(input.data()), input.size()}; }

bool finite(Vec3 v) { return norm2(0.0 * v) == 0; }

}  // namespace

void check_message(const Error& e) {
  const std::string_view text = e.what();
  claim(!text.empty() && text.size() <= 1000, "a message is empty or longer than 1000 bytes");
  for (const char c : text)
    claim(static_cast<unsigned char>(c) >= 0x20 && c != 0x7f, "a message holds a control character");
}

void scene(Bytes input) {
  try {
    const Scene s = parse_scene(text_of(input), "fuzz.toml", "/nonexistent");
    claim(s.dt > 0 && s.dt < 1e300, "the time step is not positive");
    claim(s.steps >= 0, "the number of steps is negative");
    claim(!s.materials.empty() && s.pairs.size() == s.materials.size() * s.materials.size(), "pairs are missing");
    claim(finite(s.gravity) && finite(s.domain.lower) && finite(s.domain.upper), "domain or gravity is not finite");
    for (int a = 0; a < 3; ++a) claim(s.domain.lower[a] < s.domain.upper[a], "the domain is empty");
    const auto materials = static_cast<int>(s.materials.size());
    for (const Source& q : s.sources) claim(q.material >= 0 && q.material < materials, "a source without a material");
    for (const WallSpec& w : s.walls) claim(w.material >= 0 && w.material < materials, "a wall without a material");
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
    claim(f.v.size() == f.size() && f.w.size() == f.size() && f.r.size() == f.size() && f.row.size() == f.size(),
          "columns of different lengths");
    claim(f.material.empty() || f.material.size() == f.size(), "materials of some grains only");
    claim(f.fixed.empty() || f.fixed.size() == f.size(), "`fixed` of some grains only");
    for (std::size_t k = 0; k < f.size(); ++k) {
      claim(f.r[k] > 0 && f.r[k] < 1e300, "a radius is not positive");
      claim(finite(f.x[k]) && finite(f.v[k]) && finite(f.w[k]), "a value is not finite");
      if (!f.material.empty()) claim(f.material[k] == 0, "a material that the scene lacks");
    }
    box_note(f, "fuzz.csv", {0, 0, 0}, {1, 1, 1});
  } catch (const Error& e) {
    check_message(e);
  }
}

}  // namespace talus::fuzz
