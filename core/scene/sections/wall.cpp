// [[wall]] and [wall.motion].
#include "core/scene/sections/sections.hpp"

namespace talus {
namespace {

const Keys<WallSpec> k_wall(
    {"wall", true, "a rigid wall"}, k_acts,
    {
        text_key<WallSpec>("name", "unique name", "\"gate\"").absent("(wall_0, wall_1, ...)"),
        key("shape", &WallSpec::shape,
            "plane, lateral surface of a cylinder or cone, closed box, or triangle mesh; acts through periodic sides",
            "\"plane\"")
            .required()
            .also({{"type", "wall"}, {"kind", "wall"}})
            .meaning({{"flat", "plane"},
                      {"floor", "plane"},
                      {"tube", "cylinder"},
                      {"pipe", "cylinder"},
                      {"drum", "cylinder"},
                      {"funnel", "cone"},
                      {"hopper", "cone"},
                      {"cube", "box"},
                      {"block", "box"},
                      {"cuboid", "box"},
                      {"stl", "mesh"},
                      {"obj", "mesh"},
                      {"surface", "mesh"},
                      {"triangles", "mesh"}}),
        text_key<WallSpec>("material", "material of the wall", "\"steel\"").absent("(the first material)"),
        key("point", &WallSpec::point, "m", k_coordinate,
            "a point of the plane; centre of the first end of a cylinder or cone", "[0, 0, 0.1]")
            .only("shape=plane|cylinder|cone")
            .also({{"position", "wall"}}),
        direction_key("normal", &WallSpec::normal,
                      "direction of the particles' side; a plane must be parallel to every periodic axis", "[0, 1, 1]")
            .only("shape=plane"),
        direction_key("axis", &WallSpec::axis, "direction from the first end to the other", "[1, 0, 0]")
            .only("shape=cylinder|cone"),
        key("length", &WallSpec::length, "m", {0, k_length},
            "distance of the two ends; 0 makes a cone a flat ring or disc", "0.5")
            .only("shape=cylinder|cone")
            .needed("cylinder|cone", "(required by cylinder and cone)")
            .also({{"height", "wall"}}),
        key("radius", &WallSpec::radius, "m", {0, k_length}, "radius at the first end", "0.2")
            .only("shape=cylinder|cone")
            .needed("cylinder|cone", "(required by cylinder and cone)"),
        key("radius_end", &WallSpec::radius_end, "m", {0, k_length}, "radius at the other end", "0.1")
            .only("shape=cone")
            .needed("cone", "(required by cone)"),
        key("lower", &WallSpec::lower, "m", k_coordinate, "lower corner of the box", "[0.1, 0.1, 0]")
            .only("shape=box")
            .needed("box", "(required by box)"),
        key("upper", &WallSpec::upper, "m", k_coordinate, "upper corner of the box", "[0.2, 0.2, 0.1]")
            .only("shape=box")
            .needed("box", "(required by box)"),
        key("file", &WallSpec::file,
            "STL, OBJ or PLY file, relative to the scene; facets that fold inwards by less than 32 degrees act as one "
            "smooth surface",
            "\"silo.stl\"")
            .only("shape=mesh")
            .needed("mesh", "(required by mesh)")
            .also({{"mesh", "wall"}, "stl"}),
        key("scale", &WallSpec::scale, "-", k_positive, "factor on the file's coordinates", "0.001").only("shape=mesh"),
        key("shift", &WallSpec::shift, "m", k_coordinate, "added after scaling", "[0, 0, 0.1]")
            .only("shape=mesh")
            .also({{"offset", "wall"}, {"translate", "wall"}}),
        key("appear", &WallSpec::appear, "s", k_not_negative, "the wall acts from this time", "0.1"),
        key("vanish", &WallSpec::vanish, "s", k_not_negative, "the wall is gone from this time", "0.5")
            .absent("(never)"),
    });

const Keys<WallMotion> k_motion(
    {"wall.motion", false, "motion of a wall within [start, end)"}, k_acts,
    {
        key("velocity", &WallMotion::velocity, "m/s", k_finite, "translation", "[0.1, 0, 0]"),
        direction_key("rotation_axis", &WallMotion::rotation_axis, "axis of rotation", "[0, 1, 0]")
            .beside("rotation_rate = 6.28")
            .also({{"axis", "motion"}}),
        key("rotation_rate", &WallMotion::rotation_rate, "rad/s", k_finite, "rate of rotation about the axis", "6.28")
            .also({{"omega", "", "in rad/s"},
                   {"angular_velocity", "", "in rad/s about rotation_axis"},
                   {"rpm", "", "in rad/s"},
                   {"rotation", "", "in rad/s"}}),
        key("rotation_origin", &WallMotion::rotation_origin, "m", k_coordinate, "a point of the axis of rotation",
            "[0.5, 0.5, 0]")
            .beside("rotation_rate = 6.28")
            .also({{"origin", "motion"}}),
        key("amplitude", &WallMotion::amplitude, "m", k_coordinate, "displacement amplitude of the vibration",
            "[0, 0, 0.0002]")
            .beside("frequency = 50"),
        key("frequency", &WallMotion::frequency, "Hz", k_not_negative, "frequency of the vibration", "50")
            .beside("amplitude = [0, 0, 0.0002]"),
        key("phase", &WallMotion::phase, "turns", {-1, 1},
            "phase of the vibration at its start; where it is not 0 the wall stands displaced by amplitude sin(2 pi "
            "phase) before",
            "0.25")
            .beside("amplitude = [0, 0, 0.0002]\nfrequency = 50"),
        key("start", &WallMotion::start, "s", k_not_negative, "the motion begins", "0.1")
            .beside("velocity = [0.1, 0, 0]"),
        key("end", &WallMotion::end, "s", k_not_negative, "the motion ends", "0.6")
            .absent("(never)")
            .beside("velocity = [0.1, 0, 0]"),
    });

/// Keys that move nothing without others. A zero may be one of a study's values; what is not given has been forgotten.
void refuse_idle(const SceneTable& r) {
  const SceneKey* bounds = nullptr;
  bool moves = false;
  for (const SceneKey& k : scene_keys()) {
    if (k.section != k_motion.section().name || !r.has(k.name)) continue;
    if (k.name == "start" || k.name == "end") {
      bounds = &k;
      continue;
    }
    moves = true;
    for (const std::string_view line : split_words(k.beside, "\n"))
      if (const std::string_view other = line.substr(0, line.find(' ')); !other.empty() && !r.has(other))
        r.fail(k.name, fmt::format("has no effect without '{}'", other));
  }
  if (bounds != nullptr && !moves) r.fail(bounds->name, "has no effect without a motion");
}

WallMotion read_motion(const SceneTable& r) {
  WallMotion m;
  k_motion.read(r, m);
  if (!(m.end > m.start)) r.fail("end", "must be after 'start'");
  refuse_idle(r);
  return m;
}

/// What the measures of a shape have to be together; a cylinder's second radius is its first.
void check_measures(const SceneTable& r, WallSpec& w) {
  switch (w.shape) {
    case WallShape::plane:
      break;
    case WallShape::cylinder:
      w.radius_end = w.radius;
      if (w.radius == 0) r.fail("radius", "must be > 0 for a cylinder");
      if (w.length == 0) r.fail("length", "must be > 0 for a cylinder");
      break;
    case WallShape::cone:
      if (w.radius == 0 && w.radius_end == 0) r.fail("radius_end", "one of the two radii must be > 0");
      if (w.length == 0 && w.radius == w.radius_end)
        r.fail("radius_end", "a flat ring (length 0) needs two different radii");
      break;
    case WallShape::box:
      check_box(r, w.lower, w.upper);
      break;
    case WallShape::mesh:
      if (w.file.empty()) r.fail("file", "must not be empty");
      break;
  }
}

WallSpec read_wall(const SceneTable& r, const std::vector<std::string>& materials, std::vector<std::string>& names) {
  WallSpec w;
  k_wall.read(r, w);
  w.name = unique_name(r, fmt::format("wall_{}", names.size()), names);
  if (r.has("material")) w.material = r.index("material", materials, "material");
  check_measures(r, w);
  if (r.has("motion")) w.motion = read_motion(r.section("motion"));
  if (!(w.vanish > w.appear)) r.fail("vanish", "must be after 'appear'");
  return w;
}

}  // namespace

const SectionKeys& wall_keys() { return k_wall; }
const SectionKeys& wall_motion_keys() { return k_motion; }

void read_walls(const std::vector<SceneTable>& list, const std::vector<std::string>& materials, Scene& scene) {
  std::vector<std::string> names;
  for (const SceneTable& r : list) {
    scene.walls.push_back(read_wall(r, materials, names));
    if (is_side(scene.domain, names.back())) r.fail("name", "is the name of a side of the domain, which is a wall too");
  }
}

}  // namespace talus
