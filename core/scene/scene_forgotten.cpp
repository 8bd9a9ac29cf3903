// See scene_forgotten.hpp.
#include "core/scene/scene_forgotten.hpp"

#include <algorithm>
#include <string_view>

#include "core/rules/laws/law.hpp"

namespace talus {
namespace {

bool given(const SceneText& scene, std::string_view section, std::string_view name) {
  return std::any_of(scene.values.begin(), scene.values.end(),
                     [&](const SceneValue& v) { return v.section == section && v.name == name; });
}

bool gravity_by_event(const Scene& scene) {
  return std::any_of(scene.events.begin(), scene.events.end(),
                     [](const Event& e) { return e.action == Event::Action::gravity; });
}

/// The work of pressure is left out of the gas: right where it can leave, not in a vessel that is shut and heated.
bool bomb(const Scene& s) {
  const bool heated = s.heat.on || s.conversion.on || s.gas.combustion;
  return s.gas.on && heated && std::none_of(s.gas.inlets.begin(), s.gas.inlets.end(), [](const GasInlet& i) {
           return i.kind == GasInlet::Kind::pressure;
         });
}

}  // namespace

std::vector<std::string> forgotten_keys(const SceneText& text) {
  const Scene& scene = text.scene;
  const auto none_of = [&](std::initializer_list<std::pair<std::string_view, std::string_view>> keys) {
    return std::none_of(keys.begin(), keys.end(), [&](const auto& key) { return given(text, key.first, key.second); });
  };
  std::vector<std::string> notes;
  if (none_of({{"", "gravity"}}) && !gravity_by_event(scene))
    notes.push_back("no gravity is given, so nothing falls (gravity = [0, 0, -9.81]; [0, 0, 0] says that it is meant)");
  if (none_of({{"contact", "friction"}, {"pair", "friction"}}))
    notes.push_back(
        "no friction is given, so grains slide freely and spheres never turn (contact.friction = 0.5; \"none\" says it "
        "is meant)");
  // The others require a restitution.
  if (!law_of(scene).by_modulus &&
      none_of({{"contact", "restitution"}, {"contact", "normal_damping"}, {"pair", "restitution"}}))
    notes.push_back(
        "no restitution is given, so impacts lose nothing (contact.restitution = 0.8; 1, or contact.normal_damping = "
        "0, "
        "says that it is meant)");
  if (bomb(scene))
    notes.push_back(
        "no side of the gas is open to a pressure, and it is heated: its pressure rises, but its temperature as if it "
        "could expand, which is too little in a closed vessel (gas.inlet.kind = \"pressure\" opens a side)");
  if (none_of({{"output", "particles_every"}, {"output", "csv_every"}}))
    notes.push_back(
        "no output is asked for, so only the summary and the last state are kept (output.particles_every, "
        "output.csv_every; 0 says that it is meant)");
  return notes;
}

}  // namespace talus
