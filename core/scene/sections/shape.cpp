// [[shape]], and the keys of a [[source]] that makes bodies of one.
#include "core/grains/body_shape.hpp"
#include "core/rules/laws/law.hpp"
#include "core/scene/sections/parts.hpp"

namespace talus {
namespace {

constexpr std::string_view k_made = "kind=lattice|random|stream";

const Keys<ShapeSpec> k_shape(
    {"shape", true, "a body that is no sphere, for sources; lengths are those of scale 1"},
    fixed_by("its bodies are there"),
    {
        text_key<ShapeSpec>("name", "unique name", "\"rod\"").required(),
        key("kind", &ShapeSpec::kind,
            "clump: spheres that move as one rigid body. Volume, mass, centre and inertia are those of the union, so "
            "that spheres which overlap count once. superquadric: (|x/a|^n2 + |y/b|^n2)^(n1/n2) + |z/c|^n1 = 1; its "
            "overlap is the least way that frees a pair, its force acts along it, and R* of Hertz contacts follows the "
            "curvature",
            "\"superquadric\""),
        key("semi_axes", &ShapeSpec::axes, "m", k_size, "a, b, c of a superquadric; at most 100 times each other",
            "[0.004, 0.002, 0.002]")
            .only("kind=superquadric")
            .needed("superquadric", "(for a superquadric)"),
        key("exponents", &ShapeSpec::exponents, "-", {shapes::k_exponent_least, shapes::k_exponent_most},
            "n1 (along z) and n2 (in the plane of x and y): 2 an ellipsoid, 4 and more a rounded box, 2 in the plane "
            "and "
            "more along z a rounded cylinder",
            "[8, 2]")
            .absent("([2, 2])")
            .only("kind=superquadric"),
        key("spheres", &ShapeSpec::spheres, "m", k_coordinate, "x, y, z, radius of each sphere, one after another",
            "[0, 0, -0.01, 0.01, 0, 0, 0.01, 0.01]")
            .absent("(this or file)")
            .only("kind=clump")
            .usual("clump", "file"),
        key("file", &ShapeSpec::file,
            "table whose header row names x, y, z, radius, as cases/shapes has some and `talus shape` makes them of a "
            "mesh; relative to the scene",
            "\"rod.csv\"")
            .absent("(this or spheres)")
            .only("kind=clump"),
        key("density", &ShapeSpec::density, "kg/m3", k_positive, "of its matter", "1400")
            .absent("(that of the source's material)"),
        key("mass", &ShapeSpec::mass, "kg", k_positive, "of a body of scale 1; it grows with the volume", "0.02")
            .absent("(density times volume)"),
        key("inertia", &ShapeSpec::inertia, "kg m2", k_finite,
            "moments xx, yy, zz and, if not 0, products xy, xz, yz about `centre`, of a body of scale 1 (xy = minus "
            "the "
            "sum of m x y); needs mass",
            "[2e-6, 2e-6, 1e-6]")
            .beside("mass = 0.02")
            .absent("(of the union)")
            .only("kind=clump"),
        key("centre", &ShapeSpec::centre, "m", k_coordinate, "centre of mass of a loaded body; needs inertia",
            "[0, 0, 0.002]")
            .beside("mass = 0.02\ninertia = [2e-6, 2e-6, 1e-6]")
            .absent("(of the union)")
            .only("kind=clump"),
    });

const Keys<Source> k_source(
    {"source", true, ""}, fixed_by("its bodies are there"),
    {
        text_key<Source>("shape",
                         "its grains are bodies of this [[shape]]. `size` then is the diameter of the sphere of equal "
                         "volume, without it bodies have scale 1; number and rates count bodies. Rows of a file may "
                         "name others in a column shape",
                         "\"rod\"")
            .absent("(spheres)")
            .with("[[shape]]\nname = \"rod\"\nspheres = [0, 0, -0.01, 0.01, 0, 0, 0.01, 0.01]\n"),
        key("orientation", &Source::orientation,
            "how bodies lie when they come, from where they turn freely; random: all turns alike; aligned: the shape's "
            "z "
            "axis along orientation_axis, all bodies alike; axis: the same, turned about it at random. What may not "
            "turn "
            "is frozen or driven (event.action)",
            "\"axis\"")
            .only(k_made)
            .meaning({{"fixed", "aligned"}, {"upright", "aligned"}, {"given", "aligned"}})
            .beside("shape = \"rod\"")
            .with("[[shape]]\nname = \"rod\"\nspheres = [0, 0, -0.01, 0.01, 0, 0, 0.01, 0.01]\n"),
        direction_key("orientation_axis", &Source::orientation_axis,
                      "along which the z axis of a shape lies when it comes", "[1, 0, 0]")
            .only("orientation=aligned|axis")
            .beside("shape = \"rod\"")
            .with("[[shape]]\nname = \"rod\"\nspheres = [0, 0, -0.01, 0.01, 0, 0, 0.01, 0.01]\n"),
    });

ShapeSpec read_shape(const SceneTable& r, std::vector<std::string>& names) {
  ShapeSpec s;
  k_shape.read(r, s);
  s.name = unique_name(r, "", names);
  r.exclusive("spheres", "file");
  r.exclusive("density", "mass");
  if (s.kind == ShapeSpec::Kind::superquadric) {
    if (r.has("exponents") && s.exponents.size() != 2) r.fail("exponents", "must have two numbers, n1 and n2");
    load_shape(s, "");
    return s;
  }
  if (!r.has("spheres") && !r.has("file")) r.missing("spheres", "(or file) by a clump");
  if (r.has("spheres") && (s.spheres.empty() || s.spheres.size() % 4 != 0))
    r.fail("spheres", "must have four numbers (x, y, z, radius) for each sphere");
  if (r.has("inertia") && !r.has("mass")) r.fail("inertia", "needs 'mass'");
  if (r.has("inertia") && s.inertia.size() != 3 && s.inertia.size() != 6)
    r.fail("inertia", "must have three moments, or these and three products");
  if (r.has("centre") && !r.has("inertia")) r.fail("centre", "needs 'inertia', which is about it");
  s.off_centre = r.has("centre");
  s.inertia.resize(s.inertia.size() == 3 ? 6 : s.inertia.size(), 0.0);
  if (!s.spheres.empty()) load_shape(s, "");
  return s;
}

/// The cylinder's ends are closed by sides of the domain: no body meets a rim.
bool spans(const Scene& scene, std::size_t wall) {
  const WallSpec& w = scene.walls[wall];
  const Domain& d = scene.domain;
  for (int k = 0; k < 3; ++k) {
    const int a = (k + 1) % 3, b = (k + 2) % 3;
    if (w.axis[a] != 0 || w.axis[b] != 0) continue;
    const double other = w.point[k] + (w.axis[k] > 0 ? w.length : -w.length), tiny = 1e-9 * (d.upper[k] - d.lower[k]);
    const auto& sides = d.boundary[static_cast<std::size_t>(k)];
    const bool turns =
        w.motion.rotation_rate != 0 && (w.motion.rotation_axis[a] != 0 || w.motion.rotation_axis[b] != 0);
    return fmin2(w.point[k], other) <= d.lower[k] + tiny && fmax2(w.point[k], other) >= d.upper[k] - tiny &&
           sides[0] != Boundary::open && sides[1] != Boundary::open && w.motion.velocity[k] == 0 &&
           w.motion.amplitude[k] == 0 && !turns;
  }
  return false;
}

/// What a law says of spheres alone would be wrong of them.
void refuse_beside_superquadrics(const SceneTable& root, const Scene& scene) {
  constexpr const char* refused = "cannot be had of superquadrics";
  const SceneTable contact = root.section("contact");
  if (scene.contact.rolling != Rolling::none) contact.fail("rolling", "is the shape's own work in superquadrics");
  if (scene.contact.twisting) contact.fail("twisting_friction", refused);
  if (scene.contact.cohesion != Cohesion::none) contact.fail("cohesion", refused);
  const std::vector<SceneTable> walls = root.sections("wall");
  for (std::size_t k = 0; k < walls.size() && k < scene.walls.size(); ++k)
    if (scene.walls[k].shape == WallShape::cone || (scene.walls[k].shape == WallShape::cylinder && !spans(scene, k)))
      walls[k].fail("shape",
                    "cannot be met by superquadrics: planes, boxes, meshes can, and cylinders along an axis of the "
                    "domain from one of its sides to the other, both closed or periodic");
  if (law_of(scene).adhesion != nullptr) contact.fail("model", "with adhesion cannot be had of superquadrics");
}

/// Bodies have one temperature or shells, contacts, films and an enclosure; what reaches from surface to surface knows
/// spheres alone.
void refuse_heat_of_bodies(const SceneTable& root, const Scene& scene) {
  constexpr const char* refused = "cannot be had of bodies that are no spheres";
  const SceneTable heat = root.section("heat");
  if (heat.has("gap")) heat.fail("gap", refused);
  if (scene.heat.radiation.grains) heat.section("radiation").fail("grains", refused);
  if (root.has("laser")) root.fail("laser", refused);
  for (const SceneTable& m : root.sections("material"))
    if (m.has("heat") && m.section("heat").has("expansion")) m.section("heat").fail("expansion", refused);
}

void read(const SceneTable& root, Scene& scene) {
  std::vector<std::string> names;
  for (const SceneTable& r : root.sections("shape")) scene.shapes.push_back(read_shape(r, names));
  const std::vector<SceneTable> sources = root.sections("source");
  for (std::size_t k = 0; k < sources.size(); ++k) {
    const SceneTable& r = sources[k];
    Source& s = scene.sources[k];
    k_source.read(r, s);
    if (r.has("shape")) s.shape = r.index("shape", names, "shape");
    for (const std::string_view key : {"orientation", "orientation_axis"})
      if (s.shape < 0 && r.has(key)) r.fail(key, "has no effect without 'shape'");
  }
  if (!makes_bodies(scene)) return;
  set_natural_sizes(scene);
  if (scene.heat.on) refuse_heat_of_bodies(root, scene);
  if (scene.gas.on && scene.gas.drag == GasDrag::beetstra)
    root.section("gas").fail("drag",
                             "beetstra was fitted to spheres: beside bodies that are no spheres ergun, gidaspow or "
                             "di_felice");
  if (makes_superquadrics(scene)) refuse_beside_superquadrics(root, scene);
}

}  // namespace

const PartSections& shape_sections() {
  static const PartSections all{{&k_shape, &k_source}, read};
  return all;
}

}  // namespace talus
