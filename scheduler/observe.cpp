// Views of a run: energies, frames, plan, memory, list audit. Nothing here changes the trajectory.
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <functional>
#include <numeric>

#include "core/error.hpp"
#include "scheduler/contact_blocks.hpp"
#include "scheduler/world.hpp"

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

/// Brings removals and lists up to date so that contacts of the present state can be evaluated.
void prepare_lists(World& w) {
  check_step(w, w.step + 1);
  if (!w.lists_valid || (w.has.moving_walls && w.walls.expired()) || w.any_expired.load(std::memory_order_relaxed))
    rebuild_step(w, true);  // changes no result, and the next step finds its list fresh
}

void record_contacts(World& w, std::vector<ContactRecord>& out, std::vector<std::pair<Row, Row>>& rows) {
  for (const auto& cp : w.chunks) {
    Chunk& c = *cp;
    const auto mask = c.mask;
    Column<double> h[k_max_columns];
    for (int k = 0; k < w.has.history_columns; ++k) h[k] = c.h[k];
    const auto wall_state = c.wall_state;
    const auto wall_moment = c.wall_moment;
    std::int64_t contact_end[3] = {c.contact_end[0], c.contact_end[1], c.contact_end[2]};
    narrow_chunk(w, c);
    const Scratch& s = *c.scratch;
    const std::int64_t total = c.contact_end[2];
    BlockBuffers buffers;
    ContactBlocks blocks(w, c);
    for (std::int64_t k0 = 0; k0 < total; k0 += k_block) {
      const Block b = blocks.evaluate(k0, buffers);
      for (int k = 0; k < b.n; ++k) {
        const Row i = s.ci[static_cast<std::size_t>(k0 + k)], j = s.cj[static_cast<std::size_t>(k0 + k)];
        if (i > j) continue;  // a pair across chunks is seen by both owners
        const Vec3 branch{b.x[k], b.y[k], b.z[k]}, f{b.r[0][k], b.r[1][k], b.r[2][k]};
        const double d = norm(branch);
        const Vec3 normal = (1 / d) * branch;
        ContactRecord t;
        t.a = w.id[i];
        t.b = w.id[j];
        t.normal_force = dot(f, normal) * normal;
        t.tangential_force = f - t.normal_force;
        t.overlap = b.w[k] - d;
        t.point = w.position(i) - (w.p[4L * i + 3] - 0.5 * t.overlap) * normal;
        out.push_back(t);
        rows.emplace_back(i, j);
      }
    }
    if (w.has.walls) {
      Scratch& f = *c.scratch;
      const auto size = static_cast<std::size_t>(c.hi - c.lo) * static_cast<std::size_t>(w.stride);
      if (f.f.size() < size) f.f.resize(size);
      f.clean = false;
      if (w.has.moments) clear_moments(w, c);
      const auto force = c.wall_force;
      const auto torque = c.wall_torque;
      const auto point = c.wall_point;
      wall_chunk(w, c);
      for (std::size_t k = 0; k < c.wall_state.size(); ++k) {
        const WallState& q = c.wall_state[k];
        ContactRecord t;
        t.a = w.id[q.row];
        t.b = -1 - q.contact.wall;
        t.normal_force = dot(c.wall_force[k], q.contact.normal) * q.contact.normal;
        t.tangential_force = c.wall_force[k] - t.normal_force;
        t.overlap = w.p[4L * q.row + 3] - q.contact.distance;
        t.point = c.wall_point[k];
        out.push_back(t);
        rows.emplace_back(q.row, -1);
      }
      c.wall_force = force;
      c.wall_torque = torque;
      c.wall_point = point;
    }
    c.mask = mask;
    for (int k = 0; k < w.has.history_columns; ++k) c.h[k] = h[k];
    c.run_count = 0;
    c.wall_state = wall_state;
    c.wall_moment = wall_moment;
    for (int k = 0; k < 3; ++k) c.contact_end[k] = contact_end[k];
    w.scratch.give(c.scratch);
    c.scratch = nullptr;
  }
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
  if (!w.has.energies || w.counters.steps == 0 || !w.velocity_at_old_step) return e;
  // state of step n = w.step - 1: positions p2, velocities at n the mean of n - 1/2 (v2) and n + 1/2 (v)
  const auto mean2 = [&](Row i, int from) {
    const double *v = w.v.data() + static_cast<long>(w.stride) * i, *u = w.v2.data() + static_cast<long>(w.stride) * i;
    double s = 0;
    for (int k = from; k < from + 3; ++k) s += 0.25 * (u[k] + v[k]) * (u[k] + v[k]);
    return s;
  };
  e.kinetic_translation = sum_rows(w, [&](Row i) { return 0.5 * w.mass(i) * mean2(i, 0); });
  if (w.has.rotation) e.kinetic_rotation = sum_rows(w, [&](Row i) { return 0.2 * w.mass(i) * mean2(i, 4); });
  const Vec3 weight = w.gravity_along(false);
  e.potential = -w.gravity_work - sum_rows(w, [&](Row i) {
    const double* x = w.p2.data() + 4L * i;
    const bool free = w.v[static_cast<long>(w.stride) * i + w.stride - 1] > 0;
    return free ? w.mass(i) * dot(weight, Vec3{x[0], x[1], x[2]} + w.scene.domain.lower) : 0.0;
  });
  e.elastic = sum_rows(w, [&](Row i) { return w.energy[4L * i]; });
  e.dissipated_damping = w.loss_damping;
  e.dissipated_friction = w.loss_friction;
  e.dissipated_background = w.loss_background;
  e.wall_work = w.wall_work;
  e.inserted = w.inserted_energy;
  const double total = e.kinetic_translation + e.kinetic_rotation + e.potential + e.elastic + e.dissipated_damping +
                       e.dissipated_friction + e.dissipated_background - e.wall_work - e.inserted;
  e.residual = w.start_energy_known ? total - w.start_energy : 0;
  return e;
}

Frame frame_of(World& w, const FrameRequest& q) {
  Frame f;
  if (q.contacts || q.coordination || q.stress) prepare_lists(w);
  f.step = w.step;
  f.time = static_cast<double>(w.step) * w.scene.dt;
  std::vector<Row> order;
  for (Row i = 0; i < w.n; ++i) {
    const double* x = w.p.data() + 4L * i;
    // leavers of the last drift are still in their rows until the next check
    bool inside = w.is_alive(i);
    for (int a = 0; a < 3 && inside; ++a)
      if (w.scene.domain.boundary[static_cast<std::size_t>(a)][0] == Boundary::open ||
          w.scene.domain.boundary[static_cast<std::size_t>(a)][1] == Boundary::open)
        inside = x[a] >= 0 && x[a] < w.size[a];
    if (inside) order.push_back(i);
  }
  std::sort(order.begin(), order.end(), [&](Row a, Row b) { return w.id[a] < w.id[b]; });
  std::vector<std::int32_t> place(static_cast<std::size_t>(w.n), -1);
  for (std::size_t k = 0; k < order.size(); ++k) {
    const Row i = order[k];
    place[static_cast<std::size_t>(i)] = static_cast<std::int32_t>(k);
    const double *x = w.p.data() + 4L * i, *v = w.v.data() + static_cast<long>(w.stride) * i;
    f.id.push_back(w.id[i]);
    f.x.push_back(w.position(i));
    f.v.push_back({v[0], v[1], v[2]});
    if (w.has.rotation) f.w.push_back({v[4] / x[3], v[5] / x[3], v[6] / x[3]});
    f.r.push_back(x[3]);
    if (w.has.materials) f.material.push_back(w.material[i]);
    if (w.has.fixed) f.fixed.push_back(w.fixed[i]);
  }
  if (q.contacts || q.coordination || q.stress) {
    std::vector<ContactRecord> records;
    std::vector<std::pair<Row, Row>> rows;
    record_contacts(w, records, rows);
    if (q.coordination) f.coordination.assign(order.size(), 0);
    if (q.stress) f.stress.assign(order.size(), {});
    for (std::size_t k = 0; k < records.size(); ++k) {
      const ContactRecord& c = records[k];
      const Row ends[2] = {rows[k].first, rows[k].second};
      for (int e = 0; e < 2; ++e) {
        if (ends[e] < 0 || place[static_cast<std::size_t>(ends[e])] < 0) continue;
        const auto at = static_cast<std::size_t>(place[static_cast<std::size_t>(ends[e])]);
        if (q.coordination) ++f.coordination[at];
        if (q.stress) {
          // sigma = 1/V sum l f with l from the centre to the contact point and f the force on the particle;
          // compression < 0
          const double r = f.r[at], volume = 4.0 / 3.0 * 3.14159265358979323846 * r * r * r;
          const double nf = norm(c.normal_force);
          const Vec3 force = (e == 0 ? 1.0 : -1.0) * (c.normal_force + c.tangential_force);
          const Vec3 n = nf > 0 ? (1 / nf) * c.normal_force : Vec3{};
          const Vec3 l = (e == 0 ? -1.0 : 1.0) * (r - 0.5 * c.overlap) * n;
          const double t[6] = {l.x * force.x,
                               l.y * force.y,
                               l.z * force.z,
                               0.5 * (l.x * force.y + l.y * force.x),
                               0.5 * (l.x * force.z + l.z * force.x),
                               0.5 * (l.y * force.z + l.z * force.y)};
          for (std::size_t m = 0; m < 6; ++m) f.stress[at][m] += t[m] / volume;
        }
      }
    }
    if (q.contacts) {
      std::sort(records.begin(), records.end(),
                [](const ContactRecord& a, const ContactRecord& b) { return std::tie(a.a, a.b) < std::tie(b.a, b.b); });
      f.contacts = std::move(records);
    }
  }
  if (w.has.walls && q.walls) {
    w.walls.set_step(w.step, w.scene.dt);
    f.walls = w.walls.surfaces();
    for (WallSurface& s : f.walls)
      for (Vec3& at : s.points) at = at + w.scene.domain.lower;
  }
  if (w.has.walls && q.wall_loads) {
    f.wall_loads.resize(static_cast<std::size_t>(w.walls.size()));
    for (const auto& c : w.chunks)
      for (std::size_t k = 0; k < c->wall_force.size(); ++k) {
        const WallContact& t = c->wall_state[k].contact;
        WallLoad& l = f.wall_loads[static_cast<std::size_t>(t.wall)];
        l.force = l.force - c->wall_force[k];
        // the force acts on the wall itself, at a whole number of periods from the image that the grain touches
        const Vec3 point = (t.centre + w.scene.domain.lower) - t.distance * t.normal;
        l.torque = l.torque - cross(point, c->wall_force[k]);
        if (w.has.moments) l.torque = l.torque - c->wall_torque[k];
      }
  }
  return f;
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
