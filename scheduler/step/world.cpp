// See world.hpp.
#include "scheduler/step/world.hpp"

#include <utility>

namespace talus {

World::World(Start start)
    : rules(std::move(start.rules)),
      rows(rules),
      lists(rules, start.skin, rows.columns),
      ledger(rules, rows.columns),
      walls(std::move(start.walls)),
      insertion(std::move(start.insertion)),
      planes(rules.scene),
      parts(make_parts(rules)),
      team(rules.threads) {
  clock.gravity = rules.scene.gravity;
  for (const auto& p : parts.all) {
    p->add_columns(rows.columns);
    rows.resized = rows.resized || p->resizes();
  }
  if (rules.has.energies && (rules.has.removal || rows.resized)) ledger.count_leavers(rows.columns);
  if (rules.has.energies && rows.resized) ledger.count_sizes(rows.columns);
}

}  // namespace talus
