// Views of a run: energies, plan, memory (frames: frame.cpp). Nothing here changes anything.
#include <algorithm>
#include <functional>

#include "scheduler/step/world.hpp"

namespace talus {

namespace {

/// Sum over rows in fixed blocks of 1024 (I3).
double sum_rows(const World& w, const std::function<double(Row)>& value) {
  double total = 0;
  for (Row b = 0; b < w.n; b += k_energy_block) {
    double part = 0;
    for (Row i = b; i < std::min<Row>(w.n, b + k_energy_block); ++i)
      if (w.is_alive(i)) part = part + value(i);
    total = total + part;
  }
  return total;
}

}  // namespace

double kinetic_energy_of(const World& w) {
  return sum_rows(w, [&](Row i) {
    const double* v = w.v.data() + static_cast<long>(w.stride) * i;
    return 0.5 * w.mass(i) * ((v[0] * v[0] + v[1] * v[1]) + v[2] * v[2]);
  });
}

Energies energies_of(const World& w) {
  Energies e;
  if (!w.has.energies) return e;
  const bool start = w.step == 0;
  if (!start && w.counters.steps == 0) return w.resumed;
  if (!start && !w.velocity_at_old_step) return e;
  // state of step n = w.step - 1: positions p2, velocities at n the mean of n - 1/2 (v2) and n + 1/2 (v), at the start
  // those given; before the first step what is given
  const bool given = w.step == 1 && w.scene.integrator == Integrator::velocity_verlet && w.scene.relax.steps == 0;
  const auto& old = start ? w.v : w.v2;
  const auto mean2 = [&](Row i, int from) {
    const double *u = old.data() + static_cast<long>(w.stride) * i,
                 *v = given ? u : w.v.data() + static_cast<long>(w.stride) * i;
    double s = 0;
    for (int k = from; k < from + 3; ++k) s += 0.25 * (u[k] + v[k]) * (u[k] + v[k]);
    return s;
  };
  e.kinetic_translation = sum_rows(w, [&](Row i) { return 0.5 * w.mass(i) * mean2(i, 0); });
  if (w.has.rotation) e.kinetic_rotation = sum_rows(w, [&](Row i) { return 0.2 * w.mass(i) * mean2(i, 4); });
  const Vec3 weight = w.gravity_along(false);
  e.potential = -w.work.gravity - sum_rows(w, [&](Row i) {
    const double* x = (start ? w.p : w.p2).data() + 4L * i;
    const bool free = w.v[static_cast<long>(w.stride) * i + w.stride - 1] > 0;
    return free ? w.mass(i) * dot(weight, Vec3{x[0], x[1], x[2]} + w.scene.domain.lower) : 0.0;
  });
  const Column<double> springs = start ? energy_rows(w) : Column<double>{};
  const double* stored = start ? springs.data() : w.energy.data();
  e.elastic = sum_rows(w, [&](Row i) { return stored[4L * i]; });
  e.dissipated_damping = w.work.damping;
  e.dissipated_friction = w.work.friction;
  e.dissipated_background = w.work.background;
  e.wall_work = w.work.wall;
  e.inserted = w.inserted_energy;
  const double total = e.kinetic_translation + e.kinetic_rotation + e.potential + e.elastic + e.dissipated_damping +
                       e.dissipated_friction + e.dissipated_background - e.wall_work - e.inserted;
  e.residual = w.start_energy_known ? total - w.start_energy : 0;
  return e;
}

std::size_t bytes_of(const World& w) {
  const auto size = [](const auto& c) { return c.capacity() * sizeof(c[0]); };
  std::size_t b = size(w.p) + size(w.p2) + size(w.v) + size(w.v2) + size(w.x0) + size(w.id) + size(w.material) +
                  size(w.fixed) + size(w.group) + size(w.energy) + size(w.step_work) + size(w.next_skin) +
                  size(w.outer) + size(w.near) + size(w.cell_of_row) + size(w.place_in_cell) + size(w.sx) + size(w.sy) +
                  size(w.sz) + size(w.sr) + size(w.reach) + size(w.sorted_row) + size(w.cell_start) +
                  w.list_scratch.bytes() + w.scratch.bytes();
  if (w.has.walls) b += w.walls.bytes();
  for (const auto& c : w.chunks) {
    b += size(c->outer_i) + size(c->outer_j) + size(c->pi) + size(c->pj) + size(c->mask) + size(c->wall_row) +
         size(c->wall_begin) + size(c->wall_element) + size(c->wall_distance) + size(c->wall_nearest) +
         size(c->wall_radius) + size(c->wall_state) + size(c->wall_next) + size(c->wall_force) + size(c->wall_point) +
         size(c->distributed) + size(c->wall_moment) + size(c->wall_moment_next) + size(c->wall_torque) + size(c->out);
    for (int k = 0; k < k_max_columns; ++k) b += size(c->h[k]);
  }
  return b;
}

Plan plan_of(const World& w) {
  Plan p;
  const Features& h = w.has;
  const auto node = [&](Node n, bool in, std::string why, std::string reads, std::string writes) {
    p.nodes.push_back({node_name(n), std::move(why), std::move(reads), std::move(writes), in});
  };
  node(Node::displacement_check, true, "always", "flags of integrate", "counters, removed rows");
  node(Node::insert, h.insertion || h.events,
       h.insertion || h.events ? "sources or events act during the run" : "no source or event acts during the run",
       "p, v", "rows, v");
  node(Node::sort_epoch, true, "every " + std::to_string(w.scene.sort_every) + " steps", "p, v, contacts",
       "storage order");
  node(Node::rebuild, true, "when a displacement exceeds its skin", "p, v, old lists",
       "x0, cells, lists, history order");
  node(Node::narrow_phase, true, "always", "p, list", "mask, history, contacts");
  node(Node::contact_force, true, "always", "p, v, contacts", "history, force rows");
  node(Node::wall_contact, h.walls, h.walls ? std::to_string(w.walls.size()) + " walls" : "no walls", "p, v, walls",
       "wall history, force rows");
  node(Node::integrate, true, "always", "p, v, force rows, x0", "p2, v2, flags");
  node(Node::plane_count, h.planes,
       h.planes ? std::to_string(w.planes.totals().size()) + " flux planes" : "no flux planes", "p, p2", "crossings");
  node(Node::energy, h.energies, h.energies ? "output.energies" : "output.energies is off", "energy rows, v, v2",
       "energy sums");
  const auto array = [&](const char* name, bool in, double bytes, const char* why) {
    p.arrays.push_back({name, why, in ? bytes : 0.0, in});
  };
  const double row = 8.0 * w.stride;
  array("p, p2", true, 64, "position and radius, double buffered");
  array("v, v2", true, 2 * row,
        h.rotation ? "velocity, r*spin, 1/m, double buffered" : "velocity and 1/m, double buffered");
  array("rotation lanes of v", h.rotation, 64, h.rotation ? "included above" : "no friction, no rotation");
  if (h.rotation) p.arrays.back().bytes_per_particle = 0;  // counted in v
  array("x0", true, 32, "reference position and skin of the list");
  array("id", true, 8, "identity");
  array("material", h.materials, 1, h.materials ? "several materials" : "one material");
  array("fixed", h.fixed, 1, h.fixed ? "some particles are or become fixed" : "nothing is fixed");
  array("group", h.groups, 2, h.groups ? "scene.groups" : "no groups");
  const bool profile = w.skin.policy == ListPolicy::velocity_profile;
  array("drift", profile, 16, profile ? "list.policy velocity_profile" : "displacements count from x0 itself");
  const bool cuts = w.skin.cuts();
  array("outer, near", cuts, 64, cuts ? "list.policy outer_inner" : "no outer list");
  const bool history_skins = w.skin.policy == ListPolicy::displacement_history;
  array("next skin", history_skins, 8, history_skins ? "list.policy displacement_history" : "the skins need no past");
  array("energy", h.energies, 32, h.energies ? "output.energies" : "output.energies is off");
  const double n = std::max<double>(1, w.alive);
  double lists = 0, history = 0, walls = 0;
  for (const auto& c : w.chunks) {
    lists += 8.0 * static_cast<double>(c->outer_end[2]) + 8.0 * static_cast<double>(c->end[2]) +
             static_cast<double>(c->end[2]) / 8;
    history += 8.0 * h.history_columns * static_cast<double>(c->contact_end[2]);
    walls += 4.0 * static_cast<double>(c->wall_row.size() * 2 + c->wall_element.size() * 2) +
             static_cast<double>(sizeof(WallState) * c->wall_state.size() + 8 * c->wall_moment.size());
  }
  array("pair list", true, lists / n, "rows of candidate pairs and touch bits");
  array("history", h.history_columns > 0, history / n,
        h.moment_columns > 0    ? "tangential, rolling and twisting springs of touching pairs"
        : h.rotation            ? "tangential springs of touching pairs"
        : h.history_columns > 0 ? "predicted velocity of touching pairs"
                                : "no friction, no history");
  array("moment rows", h.moments, 32, h.moments ? "rolling or twisting resistance" : "no rolling, no twisting");
  array("wall contacts", h.walls, walls / n, h.walls ? "candidates and history" : "no walls");
  array("cell index", true, 4.0 * 8 + 4.0 * static_cast<double>(w.cell_start.size()) / n,
        "sorted float32 coordinates and cell starts");
  for (const auto& a : p.arrays) p.bytes_per_particle += a.bytes_per_particle;
  p.law = std::string(w.law->name) + (h.rotation ? " with friction" : ", frictionless") +
          (h.materials ? ", per material pair" : "");
  if (w.scene.contact.rolling == Rolling::cdt) p.law += ", rolling: constant directional torque";
  if (w.scene.contact.rolling == Rolling::epsd) p.law += ", rolling: elastic-plastic spring-dashpot";
  if (w.scene.contact.twisting) p.law += ", twisting";
  if (h.cohesion) p.law += ", cohesion by contact area (sjkr)";
  p.isa = w.kernels->name;
  p.isa_why = w.isa_why;
  p.policy = policy_text(w.scene.list.policy).name;
  p.guarantee = policy_text(w.scene.list.policy).guarantee;
  p.threads = w.threads;
  p.chunk = w.chunk_size;
  p.chunks = static_cast<int>(w.chunks.size());
  p.graph = graph_picture(w);
  return p;
}

}  // namespace talus
