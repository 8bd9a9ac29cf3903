// [conversion], and the grain of a [[material]]: keys of the part in scheduler/parts/conversion.hpp.
#include <fmt/format.h>

#include "core/scene/sections/parts.hpp"

namespace talus {
namespace {

/// Without a material that converts the section would have no effect.
constexpr std::string_view k_wood = "[[material]]\nname = \"wood\"\ndensity = 600\ngrain = \"wood.toml\"\n";
constexpr std::string_view k_exchanged = "the grains have converted with it";

const Keys<ConversionScene> k_conversion(
    {"conversion", false,
     "heat, drying, pyrolysis, burning and shrinkage within grains of the materials that have a grain file; absent: "
     "none"},
    fixed_by(k_exchanged),
    {
        key("every", &ConversionScene::every, "steps", {1, k_count},
            "contact steps per step of conversion, which is linearly implicit; radius and mass go in a straight line "
            "to what came out of the last one; beside [heat] it must be heat.every",
            "100")
            .with(k_wood)
            .acts(),
        key("shells", &ConversionScene::shells, "-", {1, 32},
            "shells of a grain; of a body that is no sphere those of equal spheres of radius 3 V/A, as many as have "
            "its volume",
            "20")
            .with(k_wood),
        key("gone_below", &ConversionScene::gone_below, "-", {0, 1},
            "grains leave below this share of their first radius, bodies of their first scale; their ash is counted; "
            "0: never",
            "0.3")
            .with(k_wood),
        key("resize", &ConversionScene::resize, "radius and mass of the grains follow, of bodies their scale", "true")
            .with(k_wood),
    });

struct MaterialGrain {
  std::string grain;
};
const Keys<MaterialGrain> k_material(
    {"material", true, ""}, fixed_by(k_exchanged),
    {key("grain", &MaterialGrain::grain,
         "grain file (`talus help grain`), relative to the scene, with matter, first temperature and surroundings of "
         "the material's grains; its density must be that of the material; needs [conversion]. Of its [grain] and "
         "[time] a bed "
         "takes the temperature alone: sizes come from sources, shells from [conversion]. Beside [heat] the first "
         "temperature is that of the source, and heat reaches grains as its sections say: of the file's surroundings "
         "oxygen, carbon_dioxide, steam and pressure count; beside [gas] the cells say what the gas is. Gases of "
         "reactions then become mixtures of O2, CO2, CO, H2O, H2, CH4, tar with the same elements",
         "\"wood.toml\"")
         .absent("(does not convert)")
         .with("[conversion]\nevery = 100\n")});

/// Beside heat: the same steps; what its shells know no material says again.
void check_beside_heat(const SceneTable& root, const Scene& scene) {
  const ConversionScene& c = scene.conversion;
  const auto has_shells = [&](std::size_t k) { return k < c.grain.size() && !c.grain[k].empty(); };
  if (c.every != scene.heat.every)
    root.section("conversion")
        .fail("every",
              fmt::format("must be heat.every ({}): grains exchange at the end of the same steps", scene.heat.every));
  const std::vector<SceneTable> materials = root.sections("material"), sources = root.sections("source");
  for (std::size_t k = 0; k < materials.size(); ++k) {
    if (!has_shells(k) || !materials[k].has("heat")) continue;
    const SceneTable h = materials[k].section("heat");
    for (const char* name : {"capacity", "conductivity", "emissivity", "expansion"})
      if (h.has(name)) h.fail(name, "has no effect: the grain file of the material says it");
  }
  for (std::size_t k = 0; k < sources.size(); ++k)
    if (scene.heat.sources[k].held && has_shells(static_cast<std::size_t>(scene.sources[k].material)))
      sources[k].fail("hold_temperature", "grains that convert follow their shells");
}

void read(const SceneTable& root, Scene& scene) {
  ConversionScene& c = scene.conversion;
  c.on = root.has("conversion");
  if (c.on) {
    const SceneTable r = root.section("conversion");
    k_conversion.read(r, c);
    if (r.has("gone_below") && !c.resize) r.fail("gone_below", "has no effect with resize = false: radii stay");
  }
  bool any = false;
  for (const SceneTable& m : root.sections("material")) {
    MaterialGrain g;
    k_material.read(m, g);
    if (!c.on && m.has("grain")) m.fail("grain", "has no effect without a [conversion] section");
    if (m.has("grain") && g.grain.empty()) m.fail("grain", "must not be empty");
    if (!c.on) continue;
    any = any || !g.grain.empty();
    c.grain.push_back(g.grain);
  }
  if (c.on && scene.heat.on) check_beside_heat(root, scene);
  if (c.on && !any) root.fail("conversion", "needs a material with a grain file (material.grain)");
}

}  // namespace

const PartSections& conversion_sections() {
  static const PartSections all{{&k_conversion, &k_material}, read};
  return all;
}

}  // namespace talus
