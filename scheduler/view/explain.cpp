// The plan of a run: what `talus explain` prints, from the step table and the column registry.
#include <algorithm>

#include "scheduler/step/step.hpp"
#include "scheduler/step/world.hpp"
#include "scheduler/view/observe.hpp"

namespace talus {

namespace {

std::string names_of(const std::vector<Access>& all) {
  std::string s;
  for (const Access& a : all) s += (s.empty() ? "" : ", ") + std::string(a.array);
  return s;
}

void add_array(Plan& p, const std::string& name, bool in, double bytes, const std::string& why) {
  p.arrays.push_back({name, why, in ? bytes : 0.0, in});
}

void add_columns(const World& w, Plan& p) {
  for (const Columns::Entry& e : w.rows.columns.all()) {
    const double bytes = static_cast<double>(e.bytes) * (e.spare != nullptr ? 2 : 1);
    add_array(p, e.info.label, e.info.in, bytes, e.info.why);
    if (e.info.name != "velocity") continue;
    const bool rotation = w.rules.has.rotation;  // its bytes are counted in v
    add_array(p, "rotation lanes of v", rotation, 0, rotation ? "included above" : "no friction, no rotation");
  }
}

/// Measured, per particle.
void add_lists(const World& w, Plan& p) {
  const Features& h = w.rules.has;
  const double n = std::max<double>(1, w.rows.alive);
  double lists = 0, history = 0, walls = 0;
  for (const auto& c : w.contacts.chunks) {
    lists += 8.0 * static_cast<double>(c->outer.end[2]) + 8.0 * static_cast<double>(c->list.end[2]) +
             static_cast<double>(c->list.end[2]) / 8;
    history += 8.0 * h.history_columns * static_cast<double>(c->contacts.end[2]);
    walls += 4.0 * static_cast<double>(c->wall.row.size() * 2 + c->wall.element.size() * 2) +
             static_cast<double>(sizeof(WallState) * c->wall.state.size() + 8 * c->wall.moment.size());
  }
  add_array(p, "pair list", true, lists / n, "rows of candidate pairs and touch bits");
  add_array(p, "history", h.history_columns > 0, history / n,
            h.moment_columns > 0    ? "tangential, rolling and twisting springs of touching pairs"
            : h.superquadrics       ? "tangential springs of touching pairs; normals and arms of superquadrics"
            : h.rotation            ? "tangential springs of touching pairs"
            : h.history_columns > 0 ? "predicted velocity of touching pairs"
                                    : "no friction, and nothing to recall at a contact's end");
  add_array(p, "bodies", h.bodies, static_cast<double>(w.rows.bodies.columns.bytes()) / n,
            h.bodies ? "a source makes bodies; per row" : "no source makes bodies");
  add_array(p, "moment rows", h.moments, 32, h.moments ? "rolling or twisting resistance" : "no rolling, no twisting");
  add_array(p, "wall contacts", h.walls, walls / n, h.walls ? "candidates and history" : "no walls");
  add_array(p, "cell index", true, 4.0 * 8 + 4.0 * static_cast<double>(w.lists.grid.cell_start.size()) / n,
            "sorted float32 coordinates and cell starts");
}

std::string law_text(const World& w) {
  const Features& h = w.rules.has;
  std::string text = std::string(w.rules.law.info->name) + (h.rotation ? " with friction" : ", frictionless") +
                     (h.materials ? ", per material pair" : "");
  if (w.rules.scene.contact.rolling == Rolling::cdt) text += ", rolling: constant directional torque";
  if (w.rules.scene.contact.rolling == Rolling::epsd) text += ", rolling: elastic-plastic spring-dashpot";
  if (w.rules.scene.contact.twisting) text += ", twisting";
  if (h.cohesion) text += ", cohesion by contact area (sjkr)";
  return text;
}

}  // namespace

Plan plan_of(const World& w) {
  Plan p;
  for (const NodeSpec& n : step_table(w))
    p.nodes.push_back({n.name, n.why, names_of(n.reads), names_of(n.writes), n.in});
  add_columns(w, p);
  add_lists(w, p);
  for (const auto& a : p.arrays) p.bytes_per_particle += a.bytes_per_particle;
  p.law = law_text(w);
  p.isa = w.rules.kernels->name;
  p.isa_why = w.rules.isa_why;
  p.policy = w.lists.skin.policy->name();
  p.guarantee = w.lists.skin.policy->guarantee;
  p.threads = w.rules.threads;
  p.chunk = w.contacts.chunk_size;
  p.chunks = w.contacts.count();
  p.graph = graph_picture(w);
  return p;
}

}  // namespace talus
