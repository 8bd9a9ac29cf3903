// The socket of an optional part: physics that a scene may have or not, in files of its own. A part declares its row
// columns, its nodes, what it says in output and what it saves; parts/parts.cpp is the one list of parts, and nothing
// else names one. Invariants: a part's chunk pass writes only rows of its chunk (I7) and sums over contacts in list
// order (I3); a scene without it has none of its columns, nodes and output columns.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/base/columns.hpp"
#include "core/frame/columns.hpp"
#include "core/frame/frame.hpp"
#include "core/grains/insertion.hpp"
#include "core/walls/walls.hpp"
#include "scheduler/reports.hpp"
#include "scheduler/state/contacts.hpp"
#include "scheduler/state/rows.hpp"
#include "scheduler/state/rules.hpp"
#include "scheduler/step/node.hpp"

namespace talus {

struct Parts;
struct Team;

/// What a part's nodes see of a run.
struct PartView {
  const Rules& rules;
  const Clock& clock;
  const Rows& rows;
  const Contacts& contacts;
  const WallSet& walls;
  const Column<double>& energy;  ///< of the step by row: elastic, damping, friction, ... [J]; with Features::energies
  const Parts& parts;
  Team* team = nullptr;  ///< of nodes

  /// fn(block) for 0 ... n - 1, on the threads of the run; one after another outside of nodes. For nodes of
  /// PartNode::When::step.
  void blocks(int n, const std::function<void(int)>& fn) const;
};

/// A node of a part.
struct PartNode {
  enum class When {
    contacts,  ///< per chunk, behind its contact forces: pairs lie in the chunk's scratch, wall contacts in chunk.wall
    rows,      ///< per chunk, behind its integration
    step       ///< once, at the end of the step
  };
  std::string name;
  When when = When::contacts;
  std::vector<Access> reads, writes;
  std::int64_t every = 1;  ///< it runs in one of so many steps
  /// When::step: the chunk means nothing. When::contacts: may add to the force rows of the chunk (scratch), where it
  /// declares to.
  std::function<void(const PartView&, const Chunk&)> run;
};

/// Sizes of the rows [lo, hi) of a chunk at the end of a step; filled with those that they have. The row that leads a
/// body stands for all of it: its scale in place of a radius, its mass; nobody reads the others of it.
struct RowSizes {
  Row lo, hi;
  double *radius, *mass;  ///< [m], [kg]; a radius of 0: the row leaves
};

class Part {
 public:
  Part() = default;
  Part(const Part&) = delete;
  Part& operator=(const Part&) = delete;
  virtual ~Part() = default;

  /// Its columns; those that are `saved` come back at a resume, those with a hash seed count in the state hash.
  virtual void add_columns(Columns&) {}
  virtual std::vector<PartNode> nodes() { return {}; }
  /// Rows [first, first + a.size()) have come: from source a.source[k].
  virtual void appended(const Rows&, Row /*first*/, const NewParticles& /*a*/) {}
  /// Row i is about to go.
  virtual void removed(const Rows&, Row /*i*/) {}
  /// The last step did not happen: back to the values before it.
  virtual void take_back() {}
  /// The longest time step that it allows [s]; infinite where it does not care.
  virtual double step_limit(const PartView&) const { return k_never; }
  /// It changes radius and mass of rows while they move; `sizes` then runs per chunk behind the integration and may
  /// read rows of its chunk alone. Velocity and spin stay; a held row keeps its size, or leaves; list skins count the
  /// growth.
  virtual bool resizes() const { return false; }
  virtual void sizes(const PartView&, const Chunk&, const RowSizes&) const {}
  /// Its columns of the time series, of the present step. Their number and names never change in a run.
  virtual std::vector<PartValue> values(const PartView&) const { return {}; }
  /// Name and unit of what it knows of contacts, a column of contact files; empty: nothing.
  virtual std::pair<std::string, std::string> contact_column() const { return {}; }
  /// That of row i with row j, or where j < 0 with this wall, at the present positions; `overlap` [m].
  virtual double of_contact(const PartView&, Row /*i*/, Row /*j*/, int /*wall*/, double /*overlap*/) const { return 0; }
  /// Why it, or something of it, never acts in the run; empty where it does. Said as a warning.
  virtual std::string idle(const Rules&) const { return {}; }
  /// Of the step that ends; given once. Said as warnings.
  virtual std::vector<PartConcern> concerns() { return {}; }
  /// Lines of `talus check`.
  virtual std::vector<std::string> advice(const PartView&) const { return {}; }
  /// Work that its forces have done on the grains since the start [J]; counted like that of walls. Only with energies.
  virtual double work() const { return 0; }
  /// Its term of the state hash: what it remembers beside its columns, with a seed of its own.
  virtual std::uint64_t hash() const { return 0; }
  /// Cells to be written beside the frames of grains, as NAME.pvd; whether there are any never changes in a run.
  virtual std::optional<GridData> grid(const PartView&) const { return std::nullopt; }
  /// What it has to remember beside its columns (section "part NAME" of the checkpoint).
  virtual std::vector<std::uint8_t> save() const { return {}; }
  virtual void load(std::span<const std::uint8_t>, const std::string& /*where*/) {}
  virtual std::string name() const = 0;
};

/// The parts that a scene has.
struct Parts {
  std::vector<std::unique_ptr<Part>> all;

  void appended(const Rows& rows, Row first, const NewParticles& a) {
    for (const auto& p : all) p->appended(rows, first, a);
  }
  void removed(const Rows& rows, Row i) {
    for (const auto& p : all) p->removed(rows, i);
  }
};

/// The first part that is a T, or null: how one part finds another that it works with.
template <class T>
T* part_as(const Parts& parts) {
  for (const auto& p : parts.all)
    if (T* found = dynamic_cast<T*>(p.get())) return found;
  return nullptr;
}

/// parts/parts.cpp: the one list.
Parts make_parts(const Rules& rules);

}  // namespace talus
