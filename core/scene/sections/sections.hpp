// The sections of a scene, a file each: a table of its keys, and what only several keys together decide. Who calls it:
// core/scene/scene_file.cpp (reading), core/scene/scene_keys.cpp (the list of all keys). A reader throws Error{scene}.
#pragma once

#include <string>
#include <vector>

#include "core/scene/key.hpp"
#include "core/scene/scene.hpp"

namespace talus {

/// Keys of each section, in the order of the help.
const SectionKeys &top_keys(), &domain_keys(), &time_keys(), &damping_keys(), &material_keys(), &contact_keys(),
    &pair_keys(), &source_keys(), &source_region_keys(), &source_size_keys(), &wall_keys(), &wall_motion_keys(),
    &group_keys(), &group_region_keys(), &event_keys(), &list_keys(), &output_keys(), &output_plane_keys(),
    &output_region_keys(), &checks_keys(), &monitor_keys(), &relax_keys();

void read_top(const SceneTable& r, Scene& scene);
/// `materials`: their names.
void read_domain(const SceneTable& r, const std::vector<std::string>& materials, Scene& scene);
void read_time(const SceneTable& r, Scene& scene);
void read_damping(const SceneTable& r, Scene& scene);
/// Returns the names.
std::vector<std::string> read_materials(const std::vector<SceneTable>& list, const SceneTable& root, Scene& scene);
void read_contact(const SceneTable& r, const std::vector<SceneTable>& pairs, const std::vector<SceneTable>& materials,
                  const std::vector<std::string>& names, Scene& scene);
/// Needs the domain, the step and the groups.
void read_sources(const std::vector<SceneTable>& list, const std::vector<std::string>& materials,
                  const std::vector<std::string>& groups, Scene& scene);
void read_walls(const std::vector<SceneTable>& list, const std::vector<std::string>& materials, Scene& scene);
/// Returns the names.
std::vector<std::string> read_groups(const std::vector<SceneTable>& list, Scene& scene);
void read_events(const std::vector<SceneTable>& list, const std::vector<std::string>& groups, Scene& scene);
/// Needs everything that drives the grains.
void read_list(const SceneTable& r, Scene& scene);
void read_output(const SceneTable& r, Scene& scene);
void read_checks(const SceneTable& r, Scene& scene);
void read_relax(const SceneTable& r, Scene& scene);

/// The sections that are regions.
enum class RegionOf { source, group, output };
/// Everything but the surface of a mesh, which load_scene() reads when the scene has been found valid.
Region read_region(const SceneTable& r, RegionOf place);
/// A region that only counts where it meets the domain; `within`: on axes that are not periodic it lies in it.
Region read_region(const SceneTable& r, RegionOf place, const Domain& domain, bool within);

/// A side of the domain that is a wall, by the name that the engine gives it ("domain_x_lower").
bool is_side(const Domain& domain, const std::string& name);
void check_box(const SceneTable& r, Vec3 lower, Vec3 upper);
/// Names must be unique, since other sections refer to them. `fallback`: where none is given.
std::string unique_name(const SceneTable& r, const std::string& fallback, std::vector<std::string>& names);

}  // namespace talus
