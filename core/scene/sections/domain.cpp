// [domain] and [[material]].
#include <algorithm>

#include "core/scene/sections/sections.hpp"
#include "core/tables/particle_text.hpp"

namespace talus {
namespace {

const Keys<Domain> k_domain(
    {"domain", false, "computational box and what its sides do"},
    fixed_by("the stored positions are relative to this box"),
    {
        key("lower", &Domain::lower, "m", k_coordinate, "lower corner of the box", "[0, 0, 0]")
            .required()
            .also({{"min", "domain"}, {"low", "domain"}}),
        key("upper", &Domain::upper, "m", k_coordinate, "upper corner of the box, above the lower one on every axis",
            "[1, 1, 2]")
            .required()
            .also({{"max", "domain"}, {"high", "domain"}, {"size", "domain", "the box lies between lower and upper"}}),
        other_key<Domain>("boundary", KeyType::boundary, "", {0, 0},
                          "what the sides do: one word, or one entry per axis, each a word or a pair [lower, upper]; "
                          "open deletes particles",
                          "[\"periodic\", \"periodic\", [\"wall\", \"open\"]]")
            .choices(enum_words(Boundary{}))
            .meaning({{"pbc", "periodic"},
                      {"cyclic", "periodic"},
                      {"wrap", "periodic"},
                      {"closed", "wall"},
                      {"solid", "wall"},
                      {"fixed", "wall"},
                      {"reflect", "wall"},
                      {"free", "open"},
                      {"outflow", "open"},
                      {"delete", "open"}})
            .absent("\"wall\"")
            .also({"periodic", "boundaries"}),
        text_key<Domain>("wall_material", "material of those sides that are walls", "\"steel\"")
            .absent("(the first material)")
            .acts(),
    });

constexpr std::string_view k_place = "the state refers to it by its place in the scene";

const Keys<Material> k_material(
    {"material", true, "a material; at least one"}, k_acts,
    {
        text_key<Material>("name", "unique name", "\"glass\"").required().fixed(k_place),
        key("density", &Material::density, "kg/m3", k_positive, "density of the solid", "2500")
            .required()
            .fixed("the stored masses follow from it")
            .also({"rho"}),
        key("young", &Material::young, "Pa", k_positive, "Young's modulus", "5e7")
            .absent("(required by the Hertz models)")
            .also({"e_modulus", "elastic_modulus", "youngs_modulus", "young_modulus", "modulus"}),
        key("poisson", &Material::poisson, "-", {0, 0.5}, "Poisson's ratio", "0.25")
            .absent("(required by the Hertz models)")
            .also({"nu", "poisson_ratio", "poissons_ratio"}),
    });

}  // namespace

const SectionKeys& domain_keys() { return k_domain; }
const SectionKeys& material_keys() { return k_material; }

void read_domain(const SceneTable& r, const std::vector<std::string>& materials, Scene& scene) {
  Domain& d = scene.domain;
  k_domain.read(r, d);
  check_box(r, d.lower, d.upper);
  const auto words = r.boundary("boundary");
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t side = 0; side < 2; ++side) d.boundary[k][side] = enum_value<Boundary>(words[k][side]);
    if ((d.boundary[k][0] == Boundary::periodic) != (d.boundary[k][1] == Boundary::periodic))
      r.fail("boundary", "an axis is periodic on both sides or on none");
  }
  if (!r.has("wall_material")) return;
  d.wall_material = r.index("wall_material", materials, "material");
  const auto wall = [](const auto& axis) { return axis[0] == Boundary::wall || axis[1] == Boundary::wall; };
  if (std::none_of(d.boundary.begin(), d.boundary.end(), wall))
    r.fail("wall_material", "has no effect: no side of the domain is a wall");
}

bool is_side(const Domain& domain, const std::string& name) {
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t side = 0; side < 2; ++side)
      if (domain.boundary[k][side] == Boundary::wall &&
          name == fmt::format("domain_{}_{}", "xyz"[k], side == 0 ? "lower" : "upper"))
        return true;
  return false;
}

std::vector<std::string> read_materials(const std::vector<SceneTable>& list, const SceneTable& root, Scene& scene) {
  if (list.empty()) root.missing("material", "([[material]] with name and density)");
  if (list.size() > 255) root.fail("material", "at most 255 materials are allowed");
  std::vector<std::string> names;
  for (const SceneTable& r : list) {
    Material m;
    m.name = unique_name(r, "", names);
    // tables of particles name materials by either; a number that is another's place would mean both
    if (int place = -1; particle_text::is_number(m.name, place) && place != static_cast<int>(scene.materials.size()))
      r.fail("name", "a number would be taken for the place of another material in tables; use a word");
    k_material.read(r, m);
    scene.materials.push_back(m);
  }
  return names;
}

}  // namespace talus
