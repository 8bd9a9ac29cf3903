// Fills the Scene section by section; what a section holds stands in core/scene/sections.
#include "core/scene/scene_file.hpp"

#include "core/base/error.hpp"
#include "core/base/input_file.hpp"
#include "core/grains/region.hpp"
#include "core/scene/sections/parts.hpp"

namespace talus {
namespace {

constexpr std::uint64_t k_most_bytes = std::uint64_t{1} << 20;

}  // namespace

Scene parse_scene(std::string_view text, std::string name, std::string directory,
                  const std::vector<std::string>& overrides) {
  Scene scene;
  const SceneTable root = SceneTable::parse(text, name, overrides);
  scene.file = std::move(name);
  scene.directory = std::move(directory);
  read_top(root, scene);
  read_time(root.section("time"), scene);
  const std::vector<SceneTable> materials = root.sections("material");
  const std::vector<std::string> material_names = read_materials(materials, root, scene);
  read_domain(root.section("domain"), material_names, scene);
  read_damping(root.section("damping"), scene);
  read_contact(root.section("contact"), root.sections("pair"), materials, material_names, scene);
  const std::vector<std::string> groups = read_groups(root.sections("group"), scene);
  read_sources(root.sections("source"), material_names, groups, scene);
  read_walls(root.sections("wall"), material_names, scene);
  read_events(root.sections("event"), groups, scene);
  read_list(root.section("list"), scene);
  read_output(root.section("output"), scene);
  read_checks(root.section("checks"), scene);
  read_relax(root.section("relax"), scene);
  for (const PartSections* part : part_sections()) part->read(root, scene);
  return scene;
}

std::string read_scene_file(const std::string& path) {
  return read_input_text(path, {ErrorCode::scene, "scene file", k_most_bytes, "give the path of a TOML scene file"});
}

std::string scene_directory(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  return slash == std::string::npos ? "." : path.substr(0, slash + 1);
}

Scene load_scene(const std::string& path, const std::vector<std::string>& overrides) {
  Scene scene = parse_scene(read_scene_file(path), path, scene_directory(path), overrides);
  load_regions(scene);
  return scene;
}

}  // namespace talus
