// Frames: views of the present state. Who calls it: Simulation::frame(). Invariant: making one changes nothing, no bit
// of the state, of the ledger, of counters, lists or what the tuner knows. Contacts need lists that hold at the present
// positions, and evaluating them writes history, energies and wall loads: both happen on a copy of the run that is
// thrown away, made as a resume makes one (I6: state, then a rebuild). So a frame finds every touching pair under every
// list policy, in the steps in which lists have expired too, and its forces are those that the next step will find.
#include <algorithm>
#include <tuple>

#include "scheduler/nodes/contact_blocks.hpp"
#include "scheduler/step/world.hpp"
#include "scheduler/team/parallel.hpp"

namespace talus {

namespace {

/// A contact and the rows of its ends; j: -1 for a wall.
struct RowContact {
  Row i = 0, j = -1;
  ContactRecord record;
};

/// A row without a place: as remove_row() leaves it.
void mark_gone(World& w, Row i) {
  for (auto* p : {&w.p, &w.x0})
    for (int k = 0; k < 3; ++k) (*p)[4L * i + k] = k_gone;
  w.p[4L * i + 3] = 0;
  w.x0[4L * i + 3] = 1e300;
  for (int k = 0; k < w.stride; ++k) w.v[static_cast<long>(w.stride) * i + k] = 0;
}

/// Rows, contacts and walls of the present step, and lists of what touches now.
std::unique_ptr<World> copy_of(const World& w) {
  auto copy = std::make_unique<World>();
  World& c = *copy;
  static_cast<Setup&>(c) = w;
  c.has.energies = c.has.groups = c.has.planes = false;
  c.scene.list.policy = ListPolicy::always;  // no skins: the lists are used once
  c.skin = SkinRule(c.scene, c.r_min, c.r_max);
  c.lane_choice.prepare(w.lane_choice.threads());
  c.times.prepare(c.threads);
  c.scratch.prepare(c.threads);
  c.serial.index = -1;
  set_particle_capacity(c, w.n);
  c.p = w.p;
  c.v = w.v;
  c.id = w.id;
  c.material = w.material;
  c.fixed = w.fixed;
  c.alive = w.alive;
  c.step = w.step;
  c.law_args.start = c.step == 0 ? 1 : 0;
  c.gravity = w.gravity;
  c.walls = w.walls;
  if (c.has.walls) c.walls.set_step(c.step, c.scene.dt);
  c.chunk_size = w.chunk_size;
  c.chunk_of = w.chunk_of;
  make_chunks(c);
  for (std::size_t k = 0; k < c.chunks.size(); ++k) *c.chunks[k] = *w.chunks[k];
  for (Row i = 0; i < c.n; ++i)
    if (!c.is_alive(i) || !finite_row(c, i)) mark_gone(c, i);  // what is no number ends the run in its next step
  return copy;
}

void record_pairs(World& w, Chunk& c, std::vector<RowContact>& out) {
  const Scratch& s = *c.scratch;
  BlockBuffers buffers;
  ContactBlocks blocks(w, c);
  for (std::int64_t k0 = 0; k0 < c.contact_end[2]; k0 += k_block) {
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
      out.push_back({i, j, t});
    }
  }
}

void record_walls(World& w, Chunk& c, std::vector<RowContact>& out) {
  Scratch& s = *c.scratch;
  s.f.resize(std::max(s.f.size(), static_cast<std::size_t>(c.hi - c.lo) * static_cast<std::size_t>(w.stride)));
  if (w.has.moments) clear_moments(w, c);
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
    out.push_back({q.row, -1, t});
  }
}

/// All contacts of the present positions, ascending (a, b): an order that no chunk and no list decides.
std::vector<RowContact> present_contacts(const World& w) {
  const std::unique_ptr<World> copy = copy_of(w);
  std::vector<std::vector<RowContact>> parts(copy->chunks.size());
  with_threads(*copy, [&] {
    rebuild_lists(*copy);
    parallel(*copy, static_cast<int>(parts.size()), [&](int k) {
      Chunk& c = *copy->chunks[static_cast<std::size_t>(k)];
      auto& part = parts[static_cast<std::size_t>(k)];
      narrow_chunk(*copy, c);
      record_pairs(*copy, c, part);
      if (copy->has.walls) record_walls(*copy, c, part);
      copy->scratch.give(c.scratch);
      c.scratch = nullptr;
    });
  });
  std::vector<RowContact> all;
  for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
  // stable: contacts of a grain with several elements of a wall keep the order of these
  std::stable_sort(all.begin(), all.end(), [](const RowContact& l, const RowContact& r) {
    return std::tie(l.record.a, l.record.b) < std::tie(r.record.a, r.record.b);
  });
  return all;
}

/// sigma = 1/V l f of one end of a contact, l from the centre to the contact point, f the force on the particle;
/// compression < 0.
void add_stress(const ContactRecord& c, bool first, double r, std::array<double, 6>& stress) {
  const double volume = 4.0 / 3.0 * 3.14159265358979323846 * r * r * r;
  const double nf = norm(c.normal_force);
  const Vec3 force = (first ? 1.0 : -1.0) * (c.normal_force + c.tangential_force);
  const Vec3 n = nf > 0 ? (1 / nf) * c.normal_force : Vec3{};
  const Vec3 l = (first ? -1.0 : 1.0) * (r - 0.5 * c.overlap) * n;
  const double t[6] = {l.x * force.x,
                       l.y * force.y,
                       l.z * force.z,
                       0.5 * (l.x * force.y + l.y * force.x),
                       0.5 * (l.x * force.z + l.z * force.x),
                       0.5 * (l.y * force.z + l.z * force.y)};
  for (std::size_t m = 0; m < 6; ++m) stress[m] += t[m] / volume;
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
      if (q.stress) add_stress(c.record, e == 0, f.r[at], f.stress[at]);
    }
    if (q.contacts) f.contacts.push_back(c.record);
  }
}

/// Particles in id order; returns the place of each row in it, or -1.
std::vector<std::int32_t> add_particles(const World& w, Frame& f) {
  std::vector<Row> order;
  for (Row i = 0; i < w.n; ++i)
    if (w.is_alive(i)) order.push_back(i);
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
  return place;
}

std::vector<WallSurface> present_surfaces(const World& w) {
  std::vector<WallSurface> surfaces;
  if (w.has.moving_walls) {
    WallSet walls = w.walls;
    walls.set_step(w.step, w.scene.dt);
    surfaces = walls.surfaces();
  } else {
    surfaces = w.walls.surfaces();
  }
  for (WallSurface& s : surfaces)
    for (Vec3& at : s.points) at = at + w.scene.domain.lower;
  return surfaces;
}

/// Loads of the last executed step.
std::vector<WallLoad> wall_loads(const World& w) {
  std::vector<WallLoad> loads(static_cast<std::size_t>(w.walls.size()));
  for (const auto& c : w.chunks)
    for (std::size_t k = 0; k < c->wall_force.size(); ++k) {
      const WallContact& t = c->wall_state[k].contact;
      WallLoad& l = loads[static_cast<std::size_t>(t.wall)];
      l.force = l.force - c->wall_force[k];
      // the force acts on the wall itself, at a whole number of periods from the image that the grain touches
      const Vec3 point = (t.centre + w.scene.domain.lower) - t.distance * t.normal;
      l.torque = l.torque - cross(point, c->wall_force[k]);
      if (w.has.moments) l.torque = l.torque - c->wall_torque[k];
    }
  return loads;
}

}  // namespace

Column<double> energy_rows(const World& w) {
  const std::unique_ptr<World> copy = copy_of(w);
  World& c = *copy;
  c.has.energies = true;
  c.energy.assign(w.energy.size(), 0.0);
  with_threads(c, [&] {
    rebuild_lists(c);
    parallel(c, static_cast<int>(c.chunks.size()), [&](int k) {
      Chunk& q = *c.chunks[static_cast<std::size_t>(k)];
      narrow_chunk(c, q);
      force_chunk(c, q);
      if (c.has.walls) wall_chunk(c, q);
      c.scratch.give(q.scratch);
      q.scratch = nullptr;
    });
  });
  return std::move(c.energy);
}

Frame frame_of(const World& w, const FrameRequest& q) {
  Frame f;
  f.step = w.step;
  f.time = static_cast<double>(w.step) * w.scene.dt;
  const std::vector<std::int32_t> place = add_particles(w, f);
  if (q.contacts || q.coordination || q.stress) add_contacts(w, q, place, f);
  if (w.has.walls && q.walls) f.walls = present_surfaces(w);
  if (w.has.walls && q.wall_loads) f.wall_loads = wall_loads(w);
  return f;
}

}  // namespace talus
