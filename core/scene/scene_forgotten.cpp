// See scene_forgotten.hpp.
#include "core/scene/scene_forgotten.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "core/grains/body_shape.hpp"
#include "core/rules/laws/law.hpp"
#include "core/scene/scene_doubts.hpp"

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

/// Pieces of a clump that do not touch each other.
int pieces_of(const ShapeSpec& shape) {
  if (shape.body == nullptr || shape.kind != ShapeSpec::Kind::clump) return 1;
  const auto& all = shape.body->spheres;
  std::vector<std::size_t> next{0};
  std::vector<bool> seen(all.size(), false);
  int pieces = 0;
  for (std::size_t first = 0; first < all.size(); ++first) {
    if (seen[first]) continue;
    ++pieces;
    next.assign(1, first);
    seen[first] = true;
    while (!next.empty()) {
      const std::size_t i = next.back();
      next.pop_back();
      for (std::size_t j = 0; j < all.size(); ++j) {
        const double reach = (all[i].r + all[j].r) * (1 + 1e-9);
        if (seen[j] || norm2(all[i].x - all[j].x) > reach * reach) continue;
        seen[j] = true;
        next.push_back(j);
      }
    }
  }
  return pieces;
}

/// What is described and takes part in nothing; clumps that fall apart.
void note_unused(const Scene& scene, std::vector<std::string>& notes) {
  const auto any = [](const auto& list, auto uses) { return std::any_of(list.begin(), list.end(), uses); };
  for (std::size_t k = 0; k < scene.shapes.size(); ++k) {
    const ShapeSpec& shape = scene.shapes[k];
    if (!any(scene.sources, [&](const Source& s) { return s.shape == static_cast<int>(k); }))
      notes.push_back(fmt::format("shape '{}' is of no use: no source makes bodies of it (source.shape)", shape.name));
    if (shape.body != nullptr && shape.body->hidden > 0)
      notes.push_back(fmt::format("shape '{}': {} of its spheres lie within others and are left out", shape.name,
                                  shape.body->hidden));
    if (const int pieces = pieces_of(shape); pieces > 1)
      notes.push_back(fmt::format("shape '{}' falls into {} pieces that do not touch, yet move as one rigid body",
                                  shape.name, pieces));
  }
  for (std::size_t k = 0; k < scene.groups.size(); ++k)
    if (!any(scene.events, [&](const Event& e) { return e.group == static_cast<int>(k); }))
      notes.push_back(fmt::format("group '{}' is of no use: no event concerns it (event.group)", scene.groups[k].name));
}

/// Defaults of [heat] that every material has its own of.
void note_overridden(const SceneText& text, std::vector<std::string>& notes) {
  for (const char* name : {"capacity", "conductivity", "emissivity", "young"}) {
    const auto own = std::count_if(text.values.begin(), text.values.end(),
                                   [&](const SceneValue& v) { return v.section == "material.heat" && v.name == name; });
    if (given(text, "heat", name) && own == static_cast<std::ptrdiff_t>(text.scene.materials.size()))
      notes.push_back(fmt::format("heat.{} is of no use: every material has its own", name));
  }
}

/// Curves that do not hold at the temperature that grains begin with keep the value of their nearer end.
void note_curves(const Scene& scene, std::vector<std::string>& notes) {
  if (!scene.heat.on) return;
  for (std::size_t k = 0; k < scene.sources.size() && k < scene.heat.sources.size(); ++k) {
    const auto material = static_cast<std::size_t>(scene.sources[k].material);
    const double T = scene.heat.sources[k].temperature;
    if (scene.conversion.on && !scene.conversion.grain[material].empty()) continue;
    const MatterHeat& matter = scene.heat.matter[material];
    for (const auto& [name, curve] :
         {std::pair{"capacity", &matter.capacity}, {"conductivity", &matter.conductivity}}) {
      if (!curve->varies()) continue;
      const double low = curve->at.empty() ? curve->low : curve->at.front();
      const double high = curve->at.empty() ? curve->high : curve->at.back();
      if (T < low || T > high)
        notes.push_back(
            fmt::format("the {} of '{}' is given from {:g} to {:g} K, and grains of source '{}' begin at {:g} "
                        "K: there it keeps the value of the nearer end",
                        name, scene.materials[material].name, low, high, scene.sources[k].name, T));
    }
  }
}

}  // namespace

std::vector<std::string> forgotten_keys(const SceneText& text, bool cut) {
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
  if (none_of({{"output", "particles_every"}, {"output", "csv_every"}}))
    notes.push_back(
        "no output is asked for, so only the summary and the last state are kept (output.particles_every, "
        "output.csv_every; 0 says that it is meant)");
  note_unused(scene, notes);
  note_overridden(text, notes);
  note_curves(scene, notes);
  for (std::string& note : doubts_of(scene, cut)) notes.push_back(std::move(note));
  return notes;
}

}  // namespace talus
