// What several commands share: the scene with the replacements of the command line, numbers for people.
#include <fmt/format.h>

#include "cases/program/cli.hpp"
#include "core/base/memory.hpp"
#include "core/frame/averages.hpp"
#include "core/grains/region.hpp"
#include "core/scene/scene_file.hpp"

namespace talus::cli {

std::vector<std::string> overrides_of(const Options& options) {
  // The short options are replacements like any other, so that they meet the same range checks.
  std::vector<std::string> all = options.set;
  if (options.steps) all.push_back(fmt::format("time.steps={}", *options.steps));
  if (options.verlet_k) all.push_back(fmt::format("list.verlet_k={}", *options.verlet_k));
  return all;
}

void require_room(const Scene& scene) {
  if (scene.output.grid.on && scene.output.particles_every > 0)
    require_memory(grid_bytes(scene.output.grid.cells), "a frame of this grid", scene.file + ": output.grid",
                   "fewer cells");
}

SceneText scene_text_of(const Options& options) {
  SceneText text = read_scene_text(read_scene_file(options.scene), options.scene, scene_directory(options.scene),
                                   overrides_of(options));
  load_regions(text.scene);
  require_room(text.scene);
  return text;
}

Scene scene_of(const Options& options) { return scene_text_of(options).scene; }

std::string grouped(std::int64_t n) {
  std::string digits = fmt::format("{}", n < 0 ? -n : n);
  for (int at = static_cast<int>(digits.size()) - 3; at > 0; at -= 3)
    digits.insert(static_cast<std::size_t>(at), 1, ' ');
  return n < 0 ? "-" + digits : digits;
}

std::string human_bytes(double bytes) {
  const char* units[] = {"B", "KiB", "MiB", "GiB", "TiB"};
  int u = 0;
  while (bytes >= 1024 && u < 4) bytes /= 1024, ++u;
  return fmt::format("{:.{}f} {}", bytes, u == 0 ? 0 : 1, units[u]);
}

}  // namespace talus::cli
