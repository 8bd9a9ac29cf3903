// The monitor's judgement, and the way back from a failed step.
#include "scheduler/nodes/monitor.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.hpp"
#include "core/base/text.hpp"
#include "core/grains/source_notes.hpp"
#include "core/meshes/mesh_file.hpp"
#include "scheduler/nodes/surface.hpp"
#include "scheduler/state/step_failure.hpp"
#include "scheduler/team/parallel.hpp"

namespace talus {

namespace {

std::string name_of(const WallSet& walls, ParticleId id) {
  return id >= 0 ? fmt::format("particle {}", id) : fmt::format("wall '{}'", walls.name(static_cast<int>(-2 - id)));
}

/// What row `i` touched in the last executed step: masks and wall contacts still are those of that step.
std::vector<std::string> touching(const Rows& rows, const Contacts& contacts, const WallSet& walls, Row i) {
  std::vector<std::string> names;
  const Chunk& c = *contacts.chunks[static_cast<std::size_t>(contacts.chunk_of(i))];
  for (std::int64_t s = 0; s < c.list.end[2]; ++s) {
    if (((c.list.mask[static_cast<std::size_t>(s >> 3)] >> (s & 7)) & 1U) == 0) continue;
    const Row a = c.list.pi[static_cast<std::size_t>(s)], b = c.list.pj[static_cast<std::size_t>(s)];
    if (a == i || b == i) names.push_back(name_of(walls, rows.id[static_cast<std::size_t>(a == i ? b : a)]));
  }
  for (const WallState& t : c.wall.state)
    if (t.row == i) names.push_back(name_of(walls, -2 - t.contact.wall));
  return names;
}

void warn(std::int64_t step, Monitor& monitor, const std::string& kind, double level, double value, std::int64_t count,
          const std::string& text) {
  for (Warning& q : monitor.warnings) {
    if (q.kind != kind) continue;
    q.count += count;
    q.worst = fmax2(q.worst, value);
    return;
  }
  monitor.warnings.push_back({kind, fmt::format("step {}: {}", step, text), step, count, value, level});
}

/// Largest of all chunks; ties go to the lower ids, so that the chunks do not matter.
ChunkExtremes::Extreme reduced(const Contacts& contacts, Watch watch) {
  ChunkExtremes::Extreme top;
  for (const auto& c : contacts.chunks) {
    const auto& e = c->result.extremes.of[static_cast<int>(watch)];
    const bool first = e.value == top.value && std::pair(e.id, e.partner) < std::pair(top.id, top.partner);
    const std::int64_t count = top.count + e.count;
    if (e.value > top.value || first) top = e;
    top.count = count;
  }
  return top;
}

void judge_energy(const Rules& rules, const Clock& clock, Monitor& monitor, const Energies& e) {
  const double turned = e.kinetic_translation + e.kinetic_rotation + e.elastic + e.dissipated_damping +
                        e.dissipated_friction + e.dissipated_background + std::fabs(e.wall_work) + std::fabs(e.sizes);
  monitor.energy_scale = fmax2(monitor.energy_scale, turned);
  if (!(monitor.energy_scale > 0)) return;
  const MonitorSettings& m = rules.scene.monitor;
  const double share = std::fabs(e.residual) / monitor.energy_scale;
  const std::string text = fmt::format("the energy balance is off by {:.3g} J, {:.3g} of the {:.3g} J turned over",
                                       e.residual, share, monitor.energy_scale);
  if (share > m.max_energy) throw StepFailure({}, text, "a smaller time.step, or a larger checks.max_energy");
  if (share > m.warn_energy)
    warn(clock.step - 1, monitor, "energy", m.warn_energy, share, 1, text + "; a smaller time.step helps");
}

}  // namespace

void warn_of_part(const Clock& clock, const std::string& part, const PartConcern& found, Monitor& monitor) {
  warn(clock.step, monitor, part + " " + found.kind, found.level, found.value, found.count,
       "part '" + part + "': " + found.text);
}

void warn_of_sources(const Rules& rules, const Clock& clock, WallSet& walls, Monitor& monitor) {
  if (!rules.has.walls) return;
  for (std::string& note : sides_of_closed_walls(rules.scene, walls))
    monitor.warnings.push_back({"source", std::move(note), clock.step, 1, 0, 0});
  for (std::string& note : sides_of_open_walls(rules.scene, walls))
    monitor.warnings.push_back({"source", std::move(note), clock.step, 1, 0, 0});
  walls.set_step(clock.step, rules.scene.dt);
}

void warn_of_shortfalls(const Rules& rules, const Clock& clock, const Insertion& insertion, Monitor& monitor) {
  for (const Shortfall& f : insertion.shortfalls()) {
    const std::string kind = "stream " + rules.scene.sources[f.source].name;
    const auto waiting = static_cast<double>(f.wanted - f.placed);
    auto& all = monitor.warnings;
    const auto known = std::find_if(all.begin(), all.end(), [&](const Warning& q) { return q.kind == kind; });
    if (known == all.end()) {
      const std::string text = shortfall_text(rules.scene, f.source, f.placed, f.wanted);
      all.push_back({kind, fmt::format("step {}: {} and wait for it", clock.step, text), clock.step, 1, waiting, 0});
    } else {
      ++known->count;
      known->worst = fmax2(known->worst, waiting);
    }
  }
}

void warn_of_extent(const Rules& rules, const Clock& clock, Monitor& monitor) {
  const double widest = fmax2(rules.size.x, fmax2(rules.size.y, rules.size.z));
  if (!(rules.r_min > 0) || !(widest > 1e6 * rules.r_min)) return;
  // an overlap of 1e-3 R is then known to 2^-53 * 1e6 / 1e-3 = 1.1e-7 of itself at best
  monitor.warnings.push_back({"extent",
                              fmt::format("the domain is {:.3g} times as wide as the smallest radius; coordinates "
                                          "resolve an overlap of a thousandth of it to {:.2g} only; a smaller domain "
                                          "helps",
                                          widest / rules.r_min, 1.1e-16 * widest / (1e-3 * rules.r_min)),
                              clock.step, 1, widest / rules.r_min, 1e6});
}

void warn_of_meshes(const Rules& rules, const Clock& clock, const WallSet& walls, Monitor& monitor) {
  for (const auto& [name, report] : walls.meshes())
    if (const std::string text = doubts(report, rules.r_min); !text.empty())
      monitor.warnings.push_back({"mesh",
                                  fmt::format("wall \"{}\", mesh {}: {}", shown(name), shown(report.file), text),
                                  clock.step, 1, 1, 0});
}

/// A superquadric is as easily passed as it is thin: its travel counts in radii of the sphere within it, that of its
/// ends as it turns included, |r x n| <= sqrt(bound^2 - inner^2).
void observe_thin(const Rules& rules, const Rows& rows, Row i, ChunkExtremes& x) {
  const BodyShape* shape = superquadric_of(rules, rows, i);
  if (shape == nullptr || !rows.is_alive(i)) return;
  const double *v = rows.v2.data() + static_cast<long>(rules.stride) * i, bound = rows.p[4L * i + 3],
               inner = bound * (shape->smallest / shape->bound);
  const double speed = norm(Vec3{v[0], v[1], v[2]}), turning = norm(Vec3{v[4], v[5], v[6]}) / bound,
               lever = __builtin_sqrt(fmax2(bound * bound - inner * inner, 0));
  x.offer(Watch::travel, (speed + turning * lever) * rules.scene.dt / inner, rules.scene.monitor.warn_travel,
          rows.id[i], -1);
}

void observe_stiffness(const Rules& rules, const Rows& rows, Chunk& c) {
  const double dt = rules.scene.dt;
  ChunkExtremes& x = c.result.extremes = {};
  for (Row i = c.lo; i < c.hi; ++i) {
    const double inverse_mass = rows.v[static_cast<long>(rules.stride) * (i + 1) - 1];
    if (!rows.is_alive(i) || !(inverse_mass > 0)) continue;
    const double row = c.scratch->f[static_cast<std::size_t>(rules.stride) * static_cast<std::size_t>(i - c.lo) + 3];
    x.offer(Watch::stiffness, row * inverse_mass * (dt * dt), rules.bounds.warn_row, rows.id[i], -1);
  }
}

/// Radius within over radius about a superquadric; 1 of other rows.
double slimness(const Rules& rules, const Rows& rows, Row i) {
  const BodyShape* shape = rules.has.superquadrics ? superquadric_of(rules, rows, i) : nullptr;
  return shape != nullptr ? shape->smallest / shape->bound : 1;
}

void observe_chunk(const Rules& rules, const Clock& clock, const Rows& rows, Chunk& c) {
  const Scratch& s = *c.scratch;
  const MonitorSettings& m = rules.scene.monitor;
  const double dt = rules.scene.dt;
  const Box box = rules.scene.domain.box();
  ChunkExtremes& x = c.result.extremes;
  x.filled = true;
  for (Row i = c.lo; i < c.hi; ++i) {
    if (!rows.is_alive(i)) continue;
    const double* v = rows.v2.data() + static_cast<long>(rules.stride) * i;
    const double speed = __builtin_sqrt((v[0] * v[0] + v[1] * v[1]) + v[2] * v[2]);
    x.offer(Watch::travel, speed * dt / rows.p[4L * i + 3], m.warn_travel, rows.id[i], -1);
  }
  for (Row i = c.lo; rules.has.superquadrics && i < c.hi; ++i) observe_thin(rules, rows, i, x);
  if (rows.bodies.in && c.result.body_row > 0)
    x.offer(Watch::stiffness, c.result.body_row * (dt * dt), rules.bounds.warn_row, c.result.body_row_of, -1);
  for (std::int64_t k = 0; k < c.contacts.end[2]; ++k) {
    const Row i = s.ci[static_cast<std::size_t>(k)], j = s.cj[static_cast<std::size_t>(k)];
    if (i > j) continue;  // a pair across chunks is seen by both owners
    const double *p = rows.p.data() + 4L * i, *o = rows.p.data() + 4L * j;
    const double d = norm(box.nearest({p[0] - o[0], p[1] - o[1], p[2] - o[2]}));
    const bool shaped = rules.has.superquadrics && s.depth[static_cast<std::size_t>(k)] >= 0;
    const double share = shaped ? s.depth[static_cast<std::size_t>(k)] : (p[3] + o[3] - d) / fmin2(p[3], o[3]);
    const ParticleId a = rows.id[i], b = rows.id[j];
    x.offer(Watch::overlap, share, m.warn_overlap, a < b ? a : b, a < b ? b : a);
  }
  for (const WallState& t : c.wall.state) {
    const double r = rows.p[4L * t.row + 3];
    const ParticleId id = rows.id[t.row], wall = -2 - t.contact.wall;
    const double inner = r * slimness(rules, rows, t.row);
    x.offer(Watch::overlap, (r - t.contact.distance) / inner, m.warn_overlap, id, wall);
    x.offer(Watch::travel, norm(t.contact.velocity) * dt / r, m.warn_travel, id, wall);
  }
}

void judge_walls(const Rules& rules, const Rows& rows, const WallSet& walls) {
  const WallSet::StepTravel t = walls.step_travel();
  if (!(t.distance > rules.bounds.wall_step) || rows.alive == 0) return;
  const double allowed = rules.bounds.wall_step / rules.scene.monitor.max_travel, share = t.distance / allowed;
  throw StepFailure(
      {},
      fmt::format("wall '{}' moves {:.3g} of the smallest radius in one step: it could pass particles unseen",
                  walls.name(t.wall), share),
      fmt::format("a time.step of at most {} s, or a larger checks.max_travel",
                  at_most(rules.scene.dt * rules.scene.monitor.warn_travel / share)));
}

void judge_step(const Rules& rules, const Clock& clock, const Contacts& contacts, const WallSet& walls,
                Monitor& monitor, const Energies* energies) {
  if (contacts.chunks.empty() || !contacts.chunks.front()->result.extremes.filled) return;
  const MonitorSettings& m = rules.scene.monitor;
  const auto overlap = reduced(contacts, Watch::overlap), travel = reduced(contacts, Watch::travel),
             stiffness = reduced(contacts, Watch::stiffness);
  for (const auto& c : contacts.chunks) c->result.extremes.filled = false;
  if (travel.value > m.warn_travel) {
    const std::string text =
        travel.partner == -1
            ? fmt::format("particle {} moves {:.3g} of its radius in one step", travel.id, travel.value)
            : fmt::format("{} moves {:.3g} of the radius of particle {} in one step", name_of(walls, travel.partner),
                          travel.value, travel.id);
    // Up to one radius per step the centre cannot pass a wall before the contact is seen.
    const std::string cure =
        fmt::format("a time.step of at most {:.3g} s", rules.scene.dt * m.warn_travel / travel.value);
    if (travel.value > m.max_travel)
      throw StepFailure({travel.id}, text + ": it could pass through a wall or a particle unseen",
                        cure + ", or a larger checks.max_travel");
    warn(clock.step - 1, monitor, "travel", m.warn_travel, travel.value, travel.count, text + "; impacts want " + cure);
  }
  if (overlap.value > m.warn_overlap)
    warn(clock.step - 1, monitor, "overlap", m.warn_overlap, overlap.value, overlap.count,
         fmt::format("particle {} and {} overlap by {:.3g} of the smaller radius; stiffer contacts change less of the "
                     "geometry (`talus check` says how stiff)",
                     overlap.id, name_of(walls, overlap.partner), overlap.value));
  if (stiffness.value > rules.bounds.warn_row) {
    const double dt = rules.scene.dt, row = stiffness.value / (dt * dt),
                 effective = effective_stiffness(rules.scene, rules.bounds.time_step.ruler, row, dt);
    warn(clock.step - 1, monitor, "stiffness", m.warn_stiffness, effective, stiffness.count,
         fmt::format("the contacts of particle {} together are so stiff that step^2 k/m = {:.3g}, with dashpots and "
                     "tangential springs {:.3g}; a time.step of at most {} s is surely stable",
                     stiffness.id, stiffness.value, effective,
                     at_most(step_for_row(rules.scene, rules.bounds.time_step, row, 2))));
  }
  if (energies != nullptr) judge_energy(rules, clock, monitor, *energies);
}

void check_finite(const Rows& rows, const Contacts& contacts, const WallSet& walls, Team& team) {
  const Blocks blocks{rows.n, static_cast<int>(contacts.chunks.size())};
  std::vector<Row> bad(contacts.chunks.size(), -1);  // lowest of each block
  parallel(team, blocks.count, [&](int b) {
    for (auto i = static_cast<Row>(blocks.to(b)); i-- > static_cast<Row>(blocks.from(b));)
      if (!finite_row(rows, i)) bad[static_cast<std::size_t>(b)] = i;
  });
  for (const Row i : bad)
    if (i >= 0) fail_non_finite(rows, contacts, walls, i);
}

void fail_non_finite(const Rows& rows, const Contacts& contacts, const WallSet& walls, Row row) {
  const ParticleId id = rows.id[row];
  std::string partners;
  const std::vector<std::string> names = touching(rows, contacts, walls, row);
  for (std::size_t k = 0; k < names.size() && k < 6; ++k) partners += (k == 0 ? " in contact with " : ", ") + names[k];
  if (names.size() > 6) partners += fmt::format(" and {} more", names.size() - 6);
  throw StepFailure({id}, fmt::format("particle {}{} gets a non-finite position or velocity", id, partners),
                    "reduce the time step, check stiffness and initial overlaps");
}

}  // namespace talus
