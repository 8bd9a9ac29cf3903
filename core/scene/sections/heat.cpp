// [heat] and its sections, the thermal keys of materials and sources: keys of the part in scheduler/parts/heat.hpp.
#include <algorithm>

#include "core/scene/sections/parts.hpp"

namespace talus {
namespace {

constexpr KeyRange k_kelvin{1, 1e5}, k_share{0, 1};
constexpr std::string_view k_with = "[heat]\ntemperature = 300\ncapacity = 800\nconductivity = 1\nyoung = 7e10\n";
constexpr std::string_view k_enthalpy = "the stored enthalpies follow from it";

/// What holds for all materials that say nothing of their own.
struct General : HeatScene, MatterHeat {};

const Keys<General> k_heat(
    {"heat", false, "temperatures of grains and what exchanges heat with them; absent: grains have none"}, k_acts,
    {
        key("temperature", &HeatScene::temperature, "K", k_kelvin,
            "of the grains of sources that give none of their own. Particle files gain `temperature`, contact files "
            "`heat_flow` (conducted into particle_a, W), the series "
            "heat.total (enthalpy; that of grains with shells is conversion.heat), what came in by walls, gas, "
            "radiation, friction, held grains and sources, "
            "heat.residual, heat.lowest, heat.mean (over grains, by number), heat.highest, and the heat flow of each "
            "named wall",
            "293.15")
            .required()
            .fixed("grains have begun with it"),
        key("every", &General::every, "steps", {1, 1e9},
            "steps per heat step; a heat step in which a grain would overshoot its surroundings ends the run and says "
            "how many steps are allowed",
            "50"),
        key("error", &General::error, "K", k_positive,
            "wanted error of temperatures: a heat step then has `every` steps times a power of two, so that half of "
            "what it changes any temperature by stays below this, as far as `every` and every_most let it. For grains "
            "with one temperature: not beside [conversion], [gas] or [[laser]]. The series gains heat.steps, those of "
            "the present heat step, and heat.step_error, half of the largest change of the last one",
            "0.5")
            .absent("(each heat step has `every` steps)")
            .fixed("the present heat step has begun by it"),
        key("every_most", &General::every_most, "steps", {1, 1e9}, "most steps per heat step where error is given",
            "3200")
            .absent("(64 times every)")
            .beside("error = 0.5"),
        key("capacity", &General::capacity, "J/kg/K", k_positive, "heat capacity of materials that give none", "800")
            .absent("(required unless every material gives it)")
            .fixed(k_enthalpy)
            .usual("", "none")
            .also({"cp", "heat_capacity", "specific_heat"}),
        key("conductivity", &General::conductivity, "W/m/K", k_not_negative, "of materials that give none", "1.1")
            .absent("(required unless every material gives it)")
            .usual("", "none")
            .also({"thermal_conductivity"}),
        key("emissivity", &General::emissivity, "-", k_share,
            "of the surfaces of materials that give none, where there is radiation", "0.85"),
        key("young", &General::young, "Pa", k_positive,
            "real modulus of materials that give none: contacts of a softened model are too wide, and conduct as real "
            "ones would",
            "7e10")
            .absent("(contacts conduct as wide as they are)")
            .usual("", "none"),
        key("softening", &General::softening,
            "how real contacts follow from those of the model where `young` is given; impact: (E/E_real)^(1/5) of the "
            "radius, as in collisions of the same energy (Zhou 2010); load: (E/E_real)^(1/3), as under the same load. "
            "Not with the linear law, which takes its force as that load",
            "\"load\"")
            .with("model = \"hertz_mindlin\"\n"),
        key("friction", &General::friction,
            "what dashpots and friction of contacts dissipate heats the grains, half each", "true")
            .fixed("the balance has to begin with the run"),
    });

const Keys<MatterHeat> k_material(
    {"material.heat", false, "thermal properties of a material, in place of those of [heat]"}, k_acts,
    {
        key("capacity", &MatterHeat::capacity, "J/kg/K", k_positive, "heat capacity",
            "{ polynomial = [700, 0.4], origin = 273.15, range = [250, 1500] }")
            .absent("(heat.capacity)")
            .fixed(k_enthalpy)
            .with(k_with),
        key("conductivity", &MatterHeat::conductivity, "W/m/K", k_not_negative, "of the solid",
            "{ table = [[300, 1.1], [800, 1.6]] }")
            .absent("(heat.conductivity)")
            .with(k_with),
        key("emissivity", &MatterHeat::emissivity, "-", k_share, "of the surface, where there is radiation", "0.9")
            .absent("(heat.emissivity)")
            .with(k_with),
        key("young", &MatterHeat::young, "Pa", k_positive, "real modulus", "7e10").absent("(heat.young)").with(k_with),
        key("expansion", &MatterHeat::expansion, "1/K", {0, 1e-2},
            "rise of the radius per rise of the temperature: radius = a (1 + expansion T), where a source gives the "
            "radius at its temperature; it goes in a straight line to that of the last heat step; mass stays. A held "
            "grain keeps its radius; released, it goes to that of its temperature until the end of the heat step",
            "1e-5")
            .absent("(grains keep their radii)")
            .fixed("the radii have begun with it")
            .with(k_with),
        key("latent_heat", &MatterHeat::latent_heat, "J/kg", k_positive,
            "of melting; needs solidus and liquidus. Particle files gain `molten` (share of the grain), the series "
            "heat.molten. A molten grain stays the sphere that it was: it neither spreads nor sticks",
            "2.7e5")
            .absent("(it does not melt)")
            .fixed(k_enthalpy)
            .with(k_with)
            .beside("solidus = 1650\nliquidus = 1700"),
        key("solidus", &MatterHeat::solidus, "K", k_kelvin, "melting begins", "1650")
            .absent("(none)")
            .fixed(k_enthalpy)
            .with(k_with)
            .beside("liquidus = 1700\nlatent_heat = 2.7e5"),
        key("liquidus", &MatterHeat::liquidus, "K", k_kelvin,
            "melting ends; the latent heat is spread evenly over the sensible heat in between, at equal ends the "
            "temperature stays",
            "1700")
            .absent("(none)")
            .fixed(k_enthalpy)
            .with(k_with)
            .beside("solidus = 1650\nlatent_heat = 2.7e5"),
    });

const Keys<SourceHeat> k_source(
    {"source", true, ""}, fixed_by("its grains have begun with it"),
    {
        key("temperature", &SourceHeat::temperature, "K", k_kelvin, "of its grains; needs [heat]", "500")
            .absent("(heat.temperature)")
            .with(k_with),
        key("hold_temperature", &SourceHeat::held, "its grains keep their temperature; needs [heat]", "true")
            .with(k_with),
    });

const Keys<WallHeat> k_wall(
    {"heat.wall", true, "exchange of a wall with the grains that touch it; a wall without one is adiabatic"}, k_acts,
    {
        key("wall", &WallHeat::wall, "name of a wall or of a side (domain_x_lower ... domain_z_upper)",
            "\"domain_z_lower\"")
            .required(),
        key("temperature", &WallHeat::temperature, "K", k_kelvin,
            "of the wall, or beyond its layer; the conductivity of its material is taken there; this or flux",
            "[[0, 300], [10, 400]]")
            .absent("(none)")
            .usual("", "flux"),
        key("flux", &WallHeat::flux, "W/m2", k_finite,
            "heat per area of the wall (all of it, outside of the domain too; once, however many images it has), "
            "shared "
            "by the grains that touch it in proportion to their contact conductances; where none does, nothing enters",
            "2000")
            .absent("(none)"),
        key("layer", &WallHeat::layer, "m, W/m/K", k_positive,
            "[thickness, conductivity] of a layer before the wall, over the cross-section of the grain: contact, gas "
            "of the gap "
            "and radiation of its surface pass it together",
            "[0.01, 0.05]")
            .absent("(none)"),
    });

const Keys<GasHeat> k_gas(
    {"heat.gas", false, "gas of given temperature and velocity that flows past every grain"}, k_acts,
    {
        key("temperature", &GasHeat::temperature, "K", k_kelvin, "of the gas", "[[0, 300], [1, 800]]").required(),
        key("film", &GasHeat::film, "W/m2/K", k_not_negative, "coefficient, in place of a law", "50")
            .absent("(from the law)"),
        key("velocity", &GasHeat::velocity, "m/s", k_finite, "superficial velocity of the gas", "[0, 0, 0.5]"),
        key("law", &GasHeat::law,
            "Nusselt number of a grain: ranz_marshall 2 + 0.6 Re^1/2 Pr^1/3, whitaker, gunn (with the porosity), wakao",
            "\"gunn\""),
        key("porosity", &GasHeat::porosity, "-", {0, 1, true}, "of the bed, for gunn", "0.4").only("law=gunn"),
        key("conductivity", &GasHeat::conductivity, "W/m/K", k_positive, "of the gas", "0.026"),
        key("viscosity", &GasHeat::viscosity, "Pa s", k_positive, "of the gas", "1.8e-5"),
        key("density", &GasHeat::density, "kg/m3", k_positive, "of the gas", "1.2"),
        key("capacity", &GasHeat::capacity, "J/kg/K", k_positive, "of the gas", "1005"),
    });

const Keys<GapHeat> k_gap(
    {"heat.gap", false, "conduction through stagnant gas between grains that are near each other"}, k_acts,
    {
        key("conductivity", &GapHeat::conductivity, "W/m/K", k_positive, "of the gas", "0.026").required(),
        key("layer", &GapHeat::layer, "-", {0, 4, true},
            "thickness of the layer of gas that a grain carries / radius (of unequal grains their harmonic mean): two "
            "grains conduct up to a gap of two layers, grain and wall of one",
            "0.4"),
        key("least_gap", &GapHeat::least_gap, "m", k_positive, "gaps conduct as if they were at least this wide",
            "2.75e-8"),
    });

const Keys<RadiationHeat> k_radiation(
    {"heat.radiation", false, "radiation between grains and to an enclosure"}, k_acts,
    {
        key("grains", &RadiationHeat::grains,
            "between near grains, by areas that are the same seen from both: the mean of what each sees of the other, "
            "less where others stand before",
            "true")
            .usual("", "enclosure"),
        key("range", &RadiationHeat::range, "-", {0, 10, true},
            "largest gap between two grains that see each other / their mean radius. Of a wall of given temperature a "
            "grain of radius r whose middle is at d < R = r (1 + range/2) sees a disc of radius R, a share 0.5 (1 - d "
            "/ "
            "sqrt(d^2 + R^2)) of its view: 0.25 at the wall with the default, as in a bed whose grains hide the rest; "
            "a "
            "lone grain sees 0.5 of a wide wall, 0.42 with range = 10",
            "1.5"),
        key("enclosure", &RadiationHeat::enclosure, "K", k_kelvin,
            "temperature of what a grain sees where it sees no other", "1200")
            .absent("(none)"),
    });

void read_wall(const SceneTable& r, Scene& scene) {
  WallHeat w;
  k_wall.read(r, w);
  const auto same = [&](const auto& other) { return other.wall == w.wall; };
  if (std::none_of(scene.walls.begin(), scene.walls.end(), [&](const WallSpec& s) { return s.name == w.wall; }) &&
      !is_side(scene.domain, w.wall))
    r.fail("wall", "no such wall, nor a side of the domain that is one");
  if (std::any_of(scene.heat.walls.begin(), scene.heat.walls.end(), same)) r.fail("wall", "is given twice");
  r.exclusive("temperature", "flux");
  if (!w.temperature.given() && !w.flux.given()) r.missing("temperature", "(or flux)");
  if (r.has("layer") && w.layer.size() != 2) r.fail("layer", "must be [thickness, conductivity]");
  if (r.has("layer") && w.flux.given()) r.fail("layer", "has no effect with a flux");
  scene.heat.walls.push_back(w);
}

void check_melting(const SceneTable& material, const MatterHeat& m) {
  const bool any = material.has("latent_heat") || material.has("solidus") || material.has("liquidus");
  if (!any) return;
  for (const char* name : {"latent_heat", "solidus", "liquidus"})
    if (!material.has(name)) material.missing(name, "since a material that melts needs latent_heat, solidus, liquidus");
  if (m.liquidus < m.solidus) material.fail("liquidus", "must not be below the solidus");
}

/// Materials take what they lack from [heat].
void read_matter(const SceneTable& heat, const std::vector<SceneTable>& materials, const General& general,
                 HeatScene& h) {
  h.matter.assign(materials.size(), general);
  for (std::size_t k = 0; k < materials.size(); ++k) {
    MatterHeat& m = h.matter[k];
    if (materials[k].has("heat")) {
      const SceneTable own = materials[k].section("heat");
      k_material.read(own, m);
      check_melting(own, m);
      if (materials[k].has("grain") && own.has("latent_heat"))
        own.fail("latent_heat", "has no effect beside a grain file, whose shells do not melt");
    }
    if (materials[k].has("grain")) {  // its grain file says it; this is what nobody reads
      if (!m.capacity.given()) m.capacity = Curve::constant(1);
      if (!m.conductivity.given()) m.conductivity = Curve::constant(1);
    }
    const std::string why = "since the material \"" + materials[k].text("name") + "\" has none of its own";
    if (!m.capacity.given()) heat.missing("capacity", why);
    if (!m.conductivity.given()) heat.missing("conductivity", why);
  }
}

void check_young(const SceneTable& root, const SceneTable& heat, const Scene& scene) {
  const auto given = [](const MatterHeat& m) { return m.young > 0; };
  const auto& all = scene.heat.matter;
  if (std::any_of(all.begin(), all.end(), given) && !std::all_of(all.begin(), all.end(), given))
    heat.missing("young", "since some materials give theirs");
  if (heat.has("softening") && !given(all.front())) heat.fail("softening", "has no effect without young");
  if (heat.has("softening") && scene.contact.normal_stiffness > 0)
    heat.fail("softening", "has no effect with the linear law, whose force is taken as the load");
  const std::vector<SceneTable> materials = root.sections("material");
  for (std::size_t k = 0; k < all.size(); ++k) {
    const Material& m = scene.materials[k];
    if (!(all[k].young > 0) || !(m.young > all[k].young)) continue;
    const bool own = materials[k].has("heat") && materials[k].section("heat").has("young");
    (own ? materials[k].section("heat") : heat)
        .fail("young",
              fmt::format("is the real modulus, which a model softens and never stiffens: at least the {:g} Pa "
                          "of material '{}'",
                          m.young, m.name));
  }
}

void check_pace(const SceneTable& root, const SceneTable& heat, const HeatScene& h) {
  if (heat.has("every_most") && !heat.has("error")) heat.fail("every_most", "has no effect without error");
  if (heat.has("every_most") && h.every_most < h.every)
    heat.fail("every_most", fmt::format("must not be below every ({})", h.every));
  for (const char* other : {"conversion", "gas", "laser"})
    if (heat.has("error") && root.has(other))
      heat.fail("error", fmt::format("cannot be kept beside [{}], whose steps all have `every` steps", other));
}

void refuse_without_heat(const SceneTable& root) {
  const char* none = "has no effect without a [heat] section";
  for (const SceneTable& m : root.sections("material"))
    if (m.has("heat")) m.fail("heat", none);
  for (const SceneTable& s : root.sections("source"))
    for (const char* name : {"temperature", "hold_temperature"})
      if (s.has(name)) s.fail(name, none);
}

void read(const SceneTable& root, Scene& scene) {
  if (!root.has("heat")) return refuse_without_heat(root);
  const SceneTable r = root.section("heat");
  General general;
  k_heat.read(r, general);
  HeatScene& h = scene.heat = general;
  h.on = true;
  read_matter(r, root.sections("material"), general, h);
  check_young(root, r, scene);
  check_pace(root, r, h);
  const std::vector<SceneTable> sources = root.sections("source");
  for (const SceneTable& s : sources) {
    SourceHeat source;
    source.temperature = h.temperature;
    k_source.read(s, source);
    h.sources.push_back(source);
  }
  for (const SceneTable& w : r.sections("wall")) read_wall(w, scene);
  h.gas.on = r.has("gas");
  if (h.gas.on) {
    const SceneTable gas = r.section("gas");
    k_gas.read(gas, h.gas);
    if (gas.has("film"))
      for (const char* name : {"velocity", "law", "porosity", "conductivity", "viscosity", "density", "capacity"})
        if (gas.has(name)) gas.fail(name, "has no effect with a given film");
  }
  if (r.has("gap")) k_gap.read(r.section("gap"), h.gap);
  if (r.has("radiation")) {
    const SceneTable radiation = r.section("radiation");
    k_radiation.read(radiation, h.radiation);
    if (!h.radiation.grains && radiation.has("range")) radiation.fail("range", "has no effect without grains = true");
    if (!h.radiation.grains && !h.radiation.enclosure.given()) radiation.missing("enclosure", "(or grains = true)");
  }
}

}  // namespace

const PartSections& heat_sections() {
  static const PartSections all{{&k_heat, &k_material, &k_source, &k_wall, &k_gas, &k_gap, &k_radiation}, read};
  return all;
}

}  // namespace talus
