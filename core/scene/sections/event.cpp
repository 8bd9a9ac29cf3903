// [[group]] and [[event]].
#include "core/scene/sections/sections.hpp"

namespace talus {
namespace {

const Keys<GroupSpec> k_group({"group", true, "a named set of particles, for events"}, k_acts,
                              {
                                  text_key<GroupSpec>("name", "unique name", "\"bed\"")
                                      .required()
                                      .fixed("the state refers to it by its place in the scene"),
                                  key("fixed_in_file", &GroupSpec::fixed_in_file,
                                      "takes the particles with fixed = 1 in the initial files", "true")
                                      .fixed("it was decided at step 0"),
                                  other_key<GroupSpec>("ids", KeyType::id_range, "-", k_counted,
                                                       "first and last particle id, both included", "[0, 99]")
                                      .absent("(none)"),
                              });

const Keys<Event> k_event(
    {"event", true, "an action at a time"}, k_acts,
    {
        key("time", &Event::time, "s", k_not_negative, "when it happens", "0.2").required(),
        key("action", &Event::action, "what happens; drive moves the group with velocity and spin from then on",
            "\"freeze\"")
            .required()
            .meaning({{"fix", "freeze"},
                      {"stop", "freeze"},
                      {"hold", "freeze"},
                      {"unfreeze", "release"},
                      {"free", "release"},
                      {"delete", "remove"},
                      {"erase", "remove"},
                      {"kick", "set_velocity"},
                      {"move", "drive"},
                      {"push", "drive"}}),
        text_key<Event>("group", "whom it concerns", "\"bed\"")
            .only("action=freeze|release|set_velocity|remove|drive")
            .needed("freeze|release|set_velocity|remove|drive", "(required except by gravity)"),
        key("velocity", &Event::vector, "m/s", k_finite, "the new velocity", "[0, 0, 0.5]")
            .only("action=set_velocity|drive"),
        key("spin", &Event::spin, "rad/s", k_finite, "the new angular velocity", "[0, 0, 10]")
            .only("action=set_velocity|drive"),
        key("gravity", &Event::vector, "m/s2", k_finite, "the new acceleration of gravity", "[1, 0, -9.81]")
            .only("action=gravity")
            .needed("gravity", "(required by gravity)"),
    });

GroupSpec read_group(const SceneTable& r, std::vector<std::string>& names) {
  GroupSpec g;
  k_group.read(r, g);
  g.name = unique_name(r, "", names);
  if (r.has("region")) g.region = read_region(r.section("region"), RegionOf::group);
  if (r.has("ids")) {
    const std::vector<std::int64_t> ids = r.integers("ids");
    g.ids = {ids[0], ids[1]};
  }
  if (g.ids && (g.region || g.fixed_in_file)) r.fail("ids", "a group has one rule: ids, region or fixed_in_file");
  if (g.region && g.fixed_in_file) r.fail("fixed_in_file", "a group has one rule: ids, region or fixed_in_file");
  return g;
}

Event read_event(const SceneTable& r, const std::vector<std::string>& groups) {
  Event e;
  k_event.read(r, e);
  if (e.action != Event::Action::gravity) e.group = r.index("group", groups, "group");
  return e;
}

}  // namespace

const SectionKeys& group_keys() { return k_group; }
const SectionKeys& event_keys() { return k_event; }

std::vector<std::string> read_groups(const std::vector<SceneTable>& list, Scene& scene) {
  std::vector<std::string> names;
  for (const SceneTable& r : list) scene.groups.push_back(read_group(r, names));
  return names;
}

void read_events(const std::vector<SceneTable>& list, const std::vector<std::string>& groups, Scene& scene) {
  for (const SceneTable& r : list) scene.events.push_back(read_event(r, groups));
}

}  // namespace talus
