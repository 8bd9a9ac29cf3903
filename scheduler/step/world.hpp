// World: the owners of all state of a run, seen whole only by step/, view/ and Simulation. A node's function takes what
// it reads as const and what it writes, and nothing else.
#pragma once

#include <memory>

#include "core/frame/plane_count.hpp"
#include "core/grains/insertion.hpp"
#include "core/walls/walls.hpp"
#include "scheduler/lists/lists.hpp"
#include "scheduler/nodes/monitor.hpp"
#include "scheduler/part.hpp"
#include "scheduler/reports.hpp"
#include "scheduler/state/clock.hpp"
#include "scheduler/state/contacts.hpp"
#include "scheduler/state/ledger.hpp"
#include "scheduler/state/rows.hpp"
#include "scheduler/step/start.hpp"
#include "scheduler/team/team.hpp"

namespace talus {

struct World {
  const Rules rules;
  Clock clock;
  Rows rows;
  Contacts contacts;
  Lists lists;
  Ledger ledger;
  Counters counters;
  Monitor monitor;
  WallSet walls;  ///< positions relative to the domain's lower corner, like p
  std::unique_ptr<Insertion> insertion;
  PlaneCounts planes;
  Parts parts;
  Team team;

  explicit World(Start start);
};

inline PartView view_of(const World& w) {
  return {w.rules, w.clock, w.rows, w.contacts, w.walls, w.ledger.rows, w.parts};
}
inline PartView view_of(World& w) {
  return {w.rules, w.clock, w.rows, w.contacts, w.walls, w.ledger.rows, w.parts, &w.team};
}

}  // namespace talus
