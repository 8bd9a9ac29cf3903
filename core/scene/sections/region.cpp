// Parts of space: the same keys wherever a section describes one.
#include "core/grains/region.hpp"

#include "core/scene/sections/sections.hpp"

namespace talus {
namespace {

std::vector<Key<Region>> keys_of_a_region() {
  return {
      key("shape", &Region::shape, "box, cylinder about any axis, sphere, or the inside of a watertight mesh",
          "\"box\"")
          .meaning({{"cube", "box"},
                    {"block", "box"},
                    {"cuboid", "box"},
                    {"ball", "sphere"},
                    {"tube", "cylinder"},
                    {"stl", "mesh"}}),
      key("lower", &Region::lower, "m", k_coordinate, "lower corner", "[0.1, 0.1, 0.1]")
          .only("shape=box")
          .needed("box", "(required by box)"),
      key("upper", &Region::upper, "m", k_coordinate, "upper corner", "[0.9, 0.9, 0.9]")
          .only("shape=box")
          .needed("box", "(required by box)"),
      key("radius", &Region::radius, "m", k_size, "makes a box the upright cylinder about its middle", "0.3")
          .only("shape=box|cylinder|sphere")
          .needed("cylinder|sphere", "(required by cylinder and sphere; a box needs none)"),
      key("point", &Region::point, "m", k_coordinate, "centre of the first end of the cylinder", "[0.5, 0.5, 0.5]")
          .only("shape=cylinder")
          .needed("cylinder", "(required by cylinder)"),
      direction_key("axis", &Region::axis, "direction from the first end to the other", "[0, 1, 0]")
          .only("shape=cylinder"),
      key("length", &Region::length, "m", k_size, "distance of the two ends", "0.2")
          .only("shape=cylinder")
          .absent("(this or end)")
          .usual("cylinder", "end"),
      other_key<Region>("end", KeyType::vector, "m", k_coordinate, "centre of the other end", "[0.5, 0.5, 0.8]")
          .only("shape=cylinder")
          .absent("(this or axis and length)"),
      key("centre", &Region::point, "m", k_coordinate, "centre of the sphere", "[0.5, 0.5, 0.5]")
          .only("shape=sphere")
          .needed("sphere", "(required by sphere)"),
      key("file", &Region::file, "STL, OBJ or PLY file without holes, relative to the scene", "\"drum.stl\"")
          .only("shape=mesh")
          .needed("mesh", "(required by mesh)"),
      key("scale", &Region::scale, "-", k_positive, "factor on the file's coordinates", "0.001").only("shape=mesh"),
      key("shift", &Region::shift, "m", k_coordinate, "added after scaling", "[0, 0, 0.1]").only("shape=mesh"),
  };
}

std::vector<Key<Region>> keys_of_a_named_region() {
  std::vector<Key<Region>> keys = keys_of_a_region();
  keys.insert(keys.begin(), text_key<Region>("name", "unique name", "\"core\"").required());
  return keys;
}

const Keys<Region> k_source({"source.region", false, "box, cylinder, sphere or inside of a mesh that a source fills"},
                            k_acts, keys_of_a_region());
const Keys<Region> k_group({"group.region", false,
                            "part of space that selects the group's particles at the time of an event"},
                           k_acts, keys_of_a_region());
const Keys<Region> k_output({"output.region", true, "a region over which averages are taken"}, k_free,
                            keys_of_a_named_region());

const Keys<Region>& keys_of(RegionOf place) {
  return place == RegionOf::source ? k_source : place == RegionOf::group ? k_group : k_output;
}

void finish_cylinder(const SceneTable& r, Region& region) {
  if (!r.has("end")) {
    r.require("length", "(or end) by shape = cylinder");
    return;
  }
  r.exclusive("length", "end");
  r.exclusive("axis", "end");
  region.axis = r.vector("end") - region.point;
  region.length = norm(region.axis);
  if (!(region.length > 0)) r.fail("end", "must differ from 'point'");
}

}  // namespace

const SectionKeys& source_region_keys() { return k_source; }
const SectionKeys& group_region_keys() { return k_group; }
const SectionKeys& output_region_keys() { return k_output; }

Region read_region(const SceneTable& r, RegionOf place) {
  Region region;
  keys_of(place).read(r, region);
  if (region.shape == Region::Shape::box) check_box(r, region.lower, region.upper);
  if (region.shape == Region::Shape::cylinder) finish_cylinder(r, region);
  if (region.shape == Region::Shape::mesh && region.file.empty()) r.fail("file", "must not be empty");
  if (region.shape == Region::Shape::cylinder || region.shape == Region::Shape::sphere) set_bounds(region);
  return region;
}

Region read_region(const SceneTable& r, RegionOf place, const Domain& domain, bool within) {
  const Region region = read_region(r, place);
  if (region.shape == Region::Shape::mesh) return region;
  if (const auto fault = region_fault(domain, region, within)) r.fail(fault->key, fault->text);
  return region;
}

}  // namespace talus
