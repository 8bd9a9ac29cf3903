// Frames: views of the present state. Who calls it: Simulation::frame(). Invariant: making one changes nothing, no bit
// of the state, of the ledger, of counters, lists or what the tuner knows. Contacts need lists that hold at the present
// positions, and evaluating them writes history, energies and wall loads: both happen on a copy of the run that is
// thrown away, made as a resume makes one (I6: state, then a rebuild). So a frame finds every touching pair under every
// list policy, in the steps in which lists have expired too, and its forces are those that the next step will find.
#include <algorithm>
#include <cstring>
#include <tuple>

#include "core/grains/body.hpp"
#include "core/walls/wall_motion.hpp"
#include "scheduler/lists/rebuild.hpp"
#include "scheduler/nodes/add_ons.hpp"
#include "scheduler/nodes/contact_blocks.hpp"
#include "scheduler/nodes/force.hpp"
#include "scheduler/nodes/narrow.hpp"
#include "scheduler/nodes/shaped_contacts.hpp"
#include "scheduler/nodes/wall_contact.hpp"
#include "scheduler/step/world.hpp"
#include "scheduler/team/parallel.hpp"
#include "scheduler/view/observe.hpp"

namespace talus {

namespace {

/// A contact and the rows of its ends; j: -1 for a wall.
struct RowContact {
  Row i = 0, j = -1;
  ContactRecord record;
  Vec3 arm_i, arm_j;  ///< from the centres of the rows to the contact point [m]
};

/// Rows, contacts and walls of the present step, and lists of what touches now.
std::unique_ptr<World> copy_of(const World& w, bool energies, bool serial = false) {
  Start start;
  start.rules = w.rules;
  if (serial) start.rules.threads = 1;
  Features& has = start.rules.has;
  has.energies = energies;
  has.groups = has.planes = false;
  start.rules.scene.list.policy = ListPolicy::always;  // no skins: the lists are used once
  start.skin = SkinRule(start.rules.scene, w.rules.r_min, w.rules.r_max);
  start.walls = w.walls;
  auto copy = std::make_unique<World>(std::move(start));
  World& c = *copy;
  c.team.lane_choice.prepare(serial ? 1 : w.team.lane_choice.threads());
  set_particle_capacity(c.rows, w.rows.n);
  c.rows.columns.copy_saved(w.rows.columns, static_cast<std::size_t>(w.rows.n));
  c.rows.alive = w.rows.alive;
  copy_bodies(w.rows, c.rows);
  c.clock = w.clock;
  if (c.rules.has.walls) c.walls.set_step(c.clock.step, c.rules.scene.dt);
  c.contacts.chunk_size = w.contacts.chunk_size;
  c.contacts.chunk_of = w.contacts.chunk_of;
  make_chunks(c.contacts, c.rows);
  for (int k = 0; k < c.contacts.count(); ++k) c.contacts[k] = w.contacts[k];
  for (Row i = 0; i < c.rows.n; ++i)  // what is no number ends the run in its next step
    if (!c.rows.is_alive(i) || !finite_row(c.rows, i)) mark_gone(c.rows, c.lists, i);
  return copy;
}

/// Makes the lists of a copy and calls fn(chunk) behind the narrow phase of each chunk.
template <class F>
void with_contacts(World& c, F fn) {
  const auto all = [&] {
    rebuild_lists(c.rules, c.clock, c.rows, c.contacts, c.lists, c.counters, c.walls, c.team);
    parallel(c.team, c.contacts.count(), [&](int k) {
      Chunk& q = c.contacts[k];
      q.scratch = c.team.scratch.take(-1);
      narrow_chunk(c.rules, c.clock, c.rows, q);
      fn(q);
      c.team.scratch.give(q.scratch);
      q.scratch = nullptr;
    });
  };
  if (c.team.threads == 1)
    all();  // within a step, too
  else
    with_threads(c.team, all);
}

ContactRecord shaped_record(const World& w, Row i, Row j, int k, const ShapedContacts& shaped, const Block& b) {
  const Vec3 normal = k_far_inverse * Vec3{b.x[k], b.y[k], b.z[k]}, f{b.r[0][k], b.r[1][k], b.r[2][k]};
  ContactRecord t;
  t.a = w.rows.id[i];
  t.b = w.rows.id[j];
  t.normal_force = dot(f, normal) * normal;
  t.tangential_force = f - t.normal_force;
  t.overlap = b.w[k];
  t.point = position_of(w.rules, w.rows, i) + shaped.arm(k);
  return t;
}

void record_pairs(const World& w, Chunk& c, std::vector<RowContact>& out) {
  const Scratch& s = *c.scratch;
  BlockBuffers buffers;
  ContactBlocks blocks(w.rules, w.clock, w.rows, c);
  for (std::int64_t k0 = 0; k0 < c.contacts.end[2]; k0 += k_block) {
    const Block b = blocks.evaluate(k0, buffers);
    for (int k = 0; k < b.n; ++k) {
      const Row i = s.ci[static_cast<std::size_t>(k0 + k)], j = s.cj[static_cast<std::size_t>(k0 + k)];
      if (i > j) continue;  // a pair across chunks is seen by both owners
      const ShapedContacts* shaped = blocks.shaped();
      if (shaped != nullptr && shaped->shaped(k)) {
        if (shaped->touches(k))
          out.push_back({i, j, shaped_record(w, i, j, k, *shaped, b), shaped->arm(k), shaped->other_arm(k)});
        continue;
      }
      const Vec3 branch{b.x[k], b.y[k], b.z[k]}, f{b.r[0][k], b.r[1][k], b.r[2][k]};
      const double d = norm(branch);
      const Vec3 normal = (1 / d) * branch;
      ContactRecord t;
      t.a = w.rows.id[i];
      t.b = w.rows.id[j];
      t.normal_force = dot(f, normal) * normal;
      t.tangential_force = f - t.normal_force;
      t.overlap = b.w[k] - d;
      t.point = position_of(w.rules, w.rows, i) - (w.rows.p[4L * i + 3] - 0.5 * t.overlap) * normal;
      // by the normal of the geometry: a force that attracts points the other way
      const double ri = w.rows.p[4L * i + 3], rj = w.rows.p[4L * j + 3];
      out.push_back({i, j, t, -(ri - 0.5 * t.overlap) * normal, (rj - 0.5 * t.overlap) * normal});
    }
  }
}

void record_walls(World& w, Chunk& c, std::vector<RowContact>& out) {
  Scratch& s = *c.scratch;
  s.f.resize(std::max(s.f.size(), static_cast<std::size_t>(c.hi - c.lo) * static_cast<std::size_t>(w.rules.stride)));
  if (w.rules.has.moments) clear_moments(c);
  wall_chunk(w.rules, w.clock, w.rows, w.lists, w.walls, w.ledger.rows, c);
  for (std::size_t k = 0; k < c.wall.state.size(); ++k) {
    const WallState& q = c.wall.state[k];
    ContactRecord t;
    t.a = w.rows.id[q.row];
    t.b = -1 - q.contact.wall;
    t.normal_force = dot(c.wall.force[k], q.contact.normal) * q.contact.normal;
    t.tangential_force = c.wall.force[k] - t.normal_force;
    t.overlap = w.rows.p[4L * q.row + 3] - q.contact.distance;
    t.point = c.wall.point[k];
    const bool shaped = w.rules.has.superquadrics && superquadric_of(w.rules, w.rows, q.row) != nullptr;
    out.push_back({q.row, -1, t, shaped ? c.wall.arm[k] : -q.contact.distance * q.contact.normal, {}});
  }
}

/// All contacts of the present positions, ascending (a, b): an order that no chunk and no list decides.
std::vector<RowContact> present_contacts(const World& w) {
  const std::unique_ptr<World> copy = copy_of(w, false);
  std::vector<std::vector<RowContact>> parts(copy->contacts.chunks.size());
  with_contacts(*copy, [&](Chunk& c) {
    auto& part = parts[static_cast<std::size_t>(c.index)];
    record_pairs(*copy, c, part);
    if (copy->rules.has.walls) record_walls(*copy, c, part);
  });
  std::vector<RowContact> all;
  for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
  // stable: contacts of a grain with several elements of a wall keep the order of these
  std::stable_sort(all.begin(), all.end(), [](const RowContact& l, const RowContact& r) {
    return std::tie(l.record.a, l.record.b) < std::tie(r.record.a, r.record.b);
  });
  return all;
}

/// Volume of the grain that a row belongs to, and the way from its centre to that of the row.
struct GrainOfRow {
  double volume;
  Vec3 offset;
};
GrainOfRow grain_of(const Rules& rules, const Rows& rows, Row i) {
  const std::int32_t b = rows.body_of(i);
  if (b < 0) return {Body{rows.p[4L * i + 3]}.volume(), {}};
  const double *x = rows.p.data() + 4L * i, *c = rows.grain_at(i), scale = rows.bodies.scale(b);
  return {shape_of(rules, rows.bodies, b).volume * (scale * scale * scale),
          rules.scene.domain.box().nearest({x[0] - c[0], x[1] - c[1], x[2] - c[2]})};
}

/// sigma = 1/V l f of one end of a contact, l from the centre of the grain to the contact point, f the force on it;
/// compression < 0.
void add_stress(const RowContact& c, bool first, const GrainOfRow& grain, std::array<double, 6>& stress) {
  const double volume = grain.volume;
  const Vec3 force = (first ? 1.0 : -1.0) * (c.record.normal_force + c.record.tangential_force);
  const Vec3 l = grain.offset + (first ? c.arm_i : c.arm_j);
  const double t[6] = {l.x * force.x,
                       l.y * force.y,
                       l.z * force.z,
                       0.5 * (l.x * force.y + l.y * force.x),
                       0.5 * (l.x * force.z + l.z * force.x),
                       0.5 * (l.y * force.z + l.z * force.y)};
  for (std::size_t m = 0; m < 6; ++m) stress[m] += t[m] / volume;
}

/// All spheres of a body show the stress of the body, summed at its first.
void share_stress(const Rows& rows, const std::vector<std::int32_t>& place, Frame& f) {
  const Bodies& bodies = rows.bodies;
  for (Row i = 0; bodies.in && i < rows.n; ++i) {
    const std::int32_t b = rows.body_of(i), at = place[static_cast<std::size_t>(i)];
    if (b < 0 || at < 0) continue;
    const auto first =
        static_cast<std::size_t>(place[static_cast<std::size_t>(bodies.first[static_cast<std::size_t>(b)])]);
    f.stress[static_cast<std::size_t>(at)] = f.stress[first];
  }
}

/// What parts know of contacts.
void add_contact_columns(const Parts& parts, const PartView& view, const std::vector<RowContact>& contacts, Frame& f) {
  for (const auto& p : parts.all) {
    const auto [name, unit] = p->contact_column();
    if (name.empty()) continue;
    ExtraColumn column{name, unit, {}};
    for (const RowContact& c : contacts)
      column.values.push_back(p->of_contact(view, c.i, c.j, static_cast<int>(-1 - c.record.b), c.record.overlap));
    f.contact_extra.push_back(std::move(column));
  }
}

void add_contacts(const World& w, const FrameRequest& q, const std::vector<std::int32_t>& place, Frame& f) {
  const std::vector<RowContact> contacts = present_contacts(w);
  if (q.coordination) f.coordination.assign(f.id.size(), 0);
  if (q.stress) f.stress.assign(f.id.size(), {});
  for (const RowContact& c : contacts) {
    const Row ends[2] = {c.i, c.j};
    for (int e = 0; e < 2; ++e) {
      if (ends[e] < 0 || place[static_cast<std::size_t>(ends[e])] < 0) continue;
      const auto at = static_cast<std::size_t>(place[static_cast<std::size_t>(ends[e])]);
      if (q.coordination) ++f.coordination[at];
      if (!q.stress) continue;
      const std::int32_t b = w.rows.body_of(ends[e]);
      const Row first = b < 0 ? ends[e] : w.rows.bodies.first[static_cast<std::size_t>(b)];
      const std::int32_t to = place[static_cast<std::size_t>(first)];
      add_stress(c, e == 0, grain_of(w.rules, w.rows, ends[e]), f.stress[static_cast<std::size_t>(to)]);
    }
    if (q.contacts) f.contacts.push_back(c.record);
  }
  if (q.stress) share_stress(w.rows, place, f);
  if (q.contacts) add_contact_columns(w.parts, view_of(w), contacts, f);
}

/// Particles in id order; returns the place of each row in it, or -1.
std::vector<std::int32_t> add_particles(const World& w, Frame& f) {
  std::vector<Row> order;
  for (Row i = 0; i < w.rows.n; ++i)
    if (w.rows.is_alive(i)) order.push_back(i);
  std::sort(order.begin(), order.end(), [&](Row a, Row b) { return w.rows.id[a] < w.rows.id[b]; });
  std::vector<std::int32_t> place(static_cast<std::size_t>(w.rows.n), -1);
  for (std::size_t k = 0; k < order.size(); ++k) {
    const Row i = order[k];
    place[static_cast<std::size_t>(i)] = static_cast<std::int32_t>(k);
    const double *x = w.rows.p.data() + 4L * i, *v = w.rows.v.data() + static_cast<long>(w.rules.stride) * i;
    f.id.push_back(w.rows.id[i]);
    f.x.push_back(position_of(w.rules, w.rows, i));
    f.v.push_back({v[0], v[1], v[2]});
    if (w.rules.has.rotation) f.w.push_back({v[4] / x[3], v[5] / x[3], v[6] / x[3]});
    f.r.push_back(x[3]);
    if (w.rows.resized && !w.rows.bodies.in) f.mass.push_back(mass_of(w.rules, w.rows, i));
    if (w.rules.has.materials) f.material.push_back(w.rows.material[i]);
    if (w.rules.has.fixed) f.fixed.push_back(w.rows.fixed[i]);
  }
  if (w.rows.bodies.in) {  // the number of a body is that of its first sphere
    ExtraColumn body{"body", "", {}};
    for (const Row i : order) {
      const std::int32_t b = w.rows.body_of(i);
      body.values.push_back(
          static_cast<double>(w.rows.id[b < 0 ? i : w.rows.bodies.first[static_cast<std::size_t>(b)]]));
    }
    f.extra.push_back(std::move(body));
  }
  for (const Columns::Entry& e : w.rows.columns.all()) {
    if (!e.info.in || !e.info.output) continue;
    ExtraColumn column{e.info.name, e.info.unit, std::vector<double>(order.size())};
    for (std::size_t k = 0; k < order.size(); ++k)
      std::memcpy(&column.values[k], e.data() + e.bytes * static_cast<std::size_t>(order[k]), sizeof(double));
    f.extra.push_back(std::move(column));
  }
  return place;
}

std::vector<BodyRecord> present_bodies(const World& w) {
  std::vector<BodyRecord> all;
  const Bodies& bodies = w.rows.bodies;
  for (std::int32_t b = 0; b < bodies.n; ++b) {
    const Row first = bodies.first[static_cast<std::size_t>(b)];
    if (!w.rows.is_alive(first)) continue;
    const BodyState s = state_of(bodies, b);
    BodyRecord r;
    r.id = w.rows.id[first];
    r.shape = bodies.shape[static_cast<std::size_t>(b)];
    r.scale = bodies.scale(b);
    r.mass = bodies.mass(b);
    r.x = centre_of(w.rules, w.rows, first);
    r.v = s.v;
    r.w = angular_velocity(w.rules, bodies, b);
    const BodyShape& shape = shape_of(w.rules, bodies, b);
    const shapes::Quaternion q = s.turn * conjugate(shape.turn);
    r.orientation = {q.w, q.x, q.y, q.z};
    if (const auto& quadric = shape.quadric) {
      r.semi_axes = r.scale * quadric->surface.axes;
      r.exponents = {quadric->surface.n1, quadric->surface.n2};
    }
    all.push_back(r);
  }
  std::sort(all.begin(), all.end(), [](const BodyRecord& a, const BodyRecord& b) { return a.id < b.id; });
  return all;
}

std::vector<WallSurface> present_surfaces(const World& w) {
  std::vector<WallSurface> surfaces;
  if (w.rules.has.moving_walls) {
    WallSet walls = w.walls;
    walls.set_step(w.clock.step, w.rules.scene.dt);
    surfaces = walls.surfaces();
  } else {
    surfaces = w.walls.surfaces();
  }
  for (WallSurface& s : surfaces)
    for (Vec3& at : s.points) at = at + w.rules.scene.domain.lower;
  return surfaces;
}

/// Loads of the last executed step.
std::vector<WallLoad> wall_loads(const World& w) {
  std::vector<WallLoad> loads(static_cast<std::size_t>(w.walls.size()));
  for (const auto& c : w.contacts.chunks)
    for (std::size_t k = 0; k < c->wall.force.size(); ++k) {
      const WallContact& t = c->wall.state[k].contact;
      WallLoad& l = loads[static_cast<std::size_t>(t.wall)];
      l.force = l.force - c->wall.force[k];
      // the force acts on the wall itself, at a whole number of periods from the image that the grain touches
      Vec3 point = (t.centre + w.rules.scene.domain.lower) - t.distance * t.normal;
      if (w.rules.has.superquadrics && superquadric_of(w.rules, w.rows, c->wall.state[k].row) != nullptr)
        point = (t.centre + w.rules.scene.domain.lower) + c->wall.arm[k];
      l.torque = l.torque - cross(point, c->wall.force[k]);
      if (w.rules.has.moments) l.torque = l.torque - c->wall.torque[k];
    }
  return loads;
}

}  // namespace

Column<double> energy_rows(const World& w, std::optional<std::int64_t> walls_of) {
  const std::unique_ptr<World> copy = copy_of(w, true, walls_of.has_value());
  World& c = *copy;
  for (std::size_t k = 0; walls_of && k < w.rules.scene.walls.size(); ++k)
    c.walls.act(static_cast<int>(k), acts_at(w.rules.scene.walls[k], *walls_of, w.rules.scene.dt));
  with_contacts(c, [&](Chunk& q) {
    force_chunk(c.rules, c.clock, c.rows, c.ledger.rows, q, {});
    if (c.rules.has.walls) wall_chunk(c.rules, c.clock, c.rows, c.lists, c.walls, c.ledger.rows, q);
  });
  return std::move(c.ledger.rows);
}

Frame frame_of(const World& w, const FrameRequest& q) {
  Frame f;
  f.step = w.clock.step;
  f.time = static_cast<double>(w.clock.step) * w.rules.scene.dt;
  const std::vector<std::int32_t> place = add_particles(w, f);
  f.bodies = present_bodies(w);
  if (q.contacts || q.coordination || q.stress) add_contacts(w, q, place, f);
  if (!q.contacts) add_contact_columns(w.parts, view_of(w), {}, f);  // their names: files are made before contacts are
  if (w.rules.has.walls && q.walls) f.walls = present_surfaces(w);
  if (w.rules.has.walls && q.wall_loads) f.wall_loads = wall_loads(w);
  return f;
}

}  // namespace talus
