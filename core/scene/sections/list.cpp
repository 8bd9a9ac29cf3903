// [list]: when and how neighbour lists are made.
#include "core/scene/sections/sections.hpp"

namespace talus {
namespace {

const Keys<ListSettings> k_list(
    {"list", false, "neighbour list; never changes a trajectory"}, k_free,
    {
        key("policy", &ListSettings::policy, "when and with which skins the list is rebuilt; all exact but fixed",
            "\"paper\"")
            .meaning({{"every_step", "always"}, {"interval", "fixed"}, {"every", "fixed"}, {"verlet", "uniform"}})
            .absent("(velocity_profile where gravity drives a flow without walls along a periodic axis, else local)"),
        other_key<ListSettings>("verlet_k", KeyType::number_or_auto, "steps", {0, 1e9},
                                "K in skin = K |v| step; \"auto\": K and floor follow the run, never its results",
                                "200")
            .absent("\"auto\"")
            .also({{"k", "list"}}),
        key("interval", &ListSettings::interval, "steps", k_counted,
            "policy fixed: steps between two rebuilds; contacts that form in between may be missed", "20"),
        key("floor", &ListSettings::floor, "-", {0, 10}, "smallest skin / particle diameter; 0 switches the floor off",
            "0.05")
            .absent("(0.02; policy paper: 0)"),
        key("acceleration", &ListSettings::acceleration_on, "acceleration term of the skin", "false")
            .absent("(true; policy paper: false)"),
        key("cap", &ListSettings::cap_on, "upper bound of the skin", "false"),
        key("uniform_skin", &ListSettings::uniform_skin, "-", {0, 100},
            "skin of the policies with one skin for all / smallest radius", "0.6")
            .also({{"skin", "list"}}),
        key("outer", &ListSettings::outer, "-", {1, 100},
            "policy outer_inner: skins of the outer list / those of the inner one", "4"),
        key("cell_factor", &ListSettings::cell_factor, "-", {0, 100},
            "cell edge / smallest admissible edge; 0: chosen by the policy", "1.25"),
    });

}  // namespace

const SectionKeys& list_keys() { return k_list; }

void read_list(const SceneTable& r, Scene& scene) {
  ListSettings l;
  l.policy = scene.fitting_policy();
  k_list.read(r, l);
  const std::optional<double> k = r.number_or_text("verlet_k");
  l.automatic = !k.has_value();
  l.verlet_k = k.value_or(l.verlet_k);
  if (l.policy == ListPolicy::fixed && l.interval < 1)
    r.fail("interval", "policy fixed needs the number of steps between two rebuilds");
  const bool paper = l.policy == ListPolicy::paper;
  if (!r.has("floor") && paper) l.floor = 0;
  l.floor_on = l.floor > 0;
  if (!r.has("acceleration") && paper) l.acceleration_on = false;
  if (l.cell_factor != 0 && l.cell_factor < 1) r.fail("cell_factor", "must be 0 (chosen by the policy) or at least 1");
  scene.list = l;
}

}  // namespace talus
