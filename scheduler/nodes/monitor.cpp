// The monitor's judgement, and the way back from a failed step.
#include "scheduler/nodes/monitor.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.hpp"
#include "core/base/text.hpp"
#include "core/grains/source_notes.hpp"
#include "scheduler/step/world.hpp"
#include "scheduler/team/parallel.hpp"

namespace talus {

namespace {

std::string name_of(const World& w, ParticleId id) {
  return id >= 0 ? fmt::format("particle {}", id) : fmt::format("wall '{}'", w.walls.name(static_cast<int>(-2 - id)));
}

/// What row `i` touched in the last executed step: masks and wall contacts still are those of that step.
std::vector<std::string> touching(const World& w, Row i) {
  std::vector<std::string> names;
  const Chunk& c = *w.chunks[static_cast<std::size_t>(w.chunk_of(i))];
  for (std::int64_t s = 0; s < c.end[2]; ++s) {
    if (((c.mask[static_cast<std::size_t>(s >> 3)] >> (s & 7)) & 1U) == 0) continue;
    const Row a = c.pi[static_cast<std::size_t>(s)], b = c.pj[static_cast<std::size_t>(s)];
    if (a == i || b == i) names.push_back(name_of(w, w.id[static_cast<std::size_t>(a == i ? b : a)]));
  }
  for (const WallState& t : c.wall_state)
    if (t.row == i) names.push_back(name_of(w, -2 - t.contact.wall));
  return names;
}

void warn(World& w, const char* kind, double level, double value, std::int64_t count, const std::string& text) {
  for (Warning& q : w.monitor.warnings) {
    if (q.kind != kind) continue;
    q.count += count;
    q.worst = fmax2(q.worst, value);
    return;
  }
  w.monitor.warnings.push_back({kind, fmt::format("step {}: {}", w.step - 1, text), w.step - 1, count, value, level});
}

/// Largest of all chunks; ties go to the lower ids, so that the chunks do not matter.
ChunkExtremes::Extreme reduced(const World& w, Watch watch) {
  ChunkExtremes::Extreme top;
  for (const auto& c : w.chunks) {
    const auto& e = c->extremes.of[static_cast<int>(watch)];
    const bool first = e.value == top.value && std::pair(e.id, e.partner) < std::pair(top.id, top.partner);
    const std::int64_t count = top.count + e.count;
    if (e.value > top.value || first) top = e;
    top.count = count;
  }
  return top;
}

void judge_energy(World& w) {
  const Energies e = energies_of(w);
  const double turned = e.kinetic_translation + e.kinetic_rotation + e.elastic + e.dissipated_damping +
                        e.dissipated_friction + e.dissipated_background + std::fabs(e.wall_work);
  w.monitor.energy_scale = fmax2(w.monitor.energy_scale, turned);
  if (!(w.monitor.energy_scale > 0)) return;
  const MonitorSettings& m = w.scene.monitor;
  const double share = std::fabs(e.residual) / w.monitor.energy_scale;
  const std::string text = fmt::format("the energy balance is off by {:.3g} J, {:.3g} of the {:.3g} J turned over",
                                       e.residual, share, w.monitor.energy_scale);
  if (share > m.max_energy) fail_step(w, {}, text, "a smaller time.step, or a larger checks.max_energy");
  if (share > m.warn_energy) warn(w, "energy", m.warn_energy, share, 1, text + "; a smaller time.step helps");
}

}  // namespace

void warn_of_sources(World& w) {
  if (!w.has.walls) return;
  for (std::string& note : sides_of_closed_walls(w.scene, w.walls))
    w.monitor.warnings.push_back({"source", std::move(note), w.step, 1, 0, 0});
  w.walls.set_step(w.step, w.scene.dt);
}

void warn_of_shortfalls(World& w) {
  for (const Shortfall& f : w.insertion->shortfalls()) {
    const std::string kind = "stream " + w.scene.sources[f.source].name;
    const auto waiting = static_cast<double>(f.wanted - f.placed);
    auto& all = w.monitor.warnings;
    const auto known = std::find_if(all.begin(), all.end(), [&](const Warning& q) { return q.kind == kind; });
    if (known == all.end()) {
      const std::string text = shortfall_text(w.scene, f.source, f.placed, f.wanted);
      all.push_back({kind, fmt::format("step {}: {} and wait for it", w.step, text), w.step, 1, waiting, 0});
    } else {
      ++known->count;
      known->worst = fmax2(known->worst, waiting);
    }
  }
}

void warn_of_extent(World& w) {
  const double widest = fmax2(w.size.x, fmax2(w.size.y, w.size.z));
  if (!(w.r_min > 0) || !(widest > 1e6 * w.r_min)) return;
  // an overlap of 1e-3 R is then known to 2^-53 * 1e6 / 1e-3 = 1.1e-7 of itself at best
  w.monitor.warnings.push_back({"extent",
                                fmt::format("the domain is {:.3g} times as wide as the smallest radius; coordinates "
                                            "resolve an overlap of a thousandth of it to {:.2g} only; a smaller domain "
                                            "helps",
                                            widest / w.r_min, 1.1e-16 * widest / (1e-3 * w.r_min)),
                                w.step, 1, widest / w.r_min, 1e6});
}

void warn_of_meshes(World& w) {
  for (const auto& [name, report] : w.walls.meshes())
    if (const std::string text = doubts(report, w.r_min); !text.empty())
      w.monitor.warnings.push_back(
          {"mesh", fmt::format("wall \"{}\", mesh {}: {}", shown(name), shown(report.file), text), w.step, 1, 1, 0});
}

void observe_chunk(World& w, Chunk& c) {
  const Scratch& s = *c.scratch;
  const MonitorSettings& m = w.scene.monitor;
  const double dt = w.scene.dt;
  const Box box = w.scene.domain.box();
  ChunkExtremes x;
  x.filled = true;
  const auto offer = [&x](Watch watch, double value, double level, ParticleId id, ParticleId partner) {
    auto& e = x.of[static_cast<int>(watch)];
    if (value > level) ++e.count;
    if (!(value >= e.value)) return;
    if (value == e.value && e.id >= 0 && !(std::pair(id, partner) < std::pair(e.id, e.partner))) return;
    e.value = value;
    e.id = id;
    e.partner = partner;
  };
  for (Row i = c.lo; i < c.hi; ++i) {
    if (!w.is_alive(i)) continue;
    const double* v = w.v2.data() + static_cast<long>(w.stride) * i;
    const double speed = __builtin_sqrt((v[0] * v[0] + v[1] * v[1]) + v[2] * v[2]);
    const double* f = s.f.data() + static_cast<long>(w.stride) * (i - c.lo);
    offer(Watch::travel, speed * dt / w.p[4L * i + 3], m.warn_travel, w.id[i], -1);
    offer(Watch::stiffness, f[3] * v[w.stride - 1] * (dt * dt), w.warn_row, w.id[i], -1);
  }
  for (std::int64_t k = 0; k < c.contact_end[2]; ++k) {
    const Row i = s.ci[static_cast<std::size_t>(k)], j = s.cj[static_cast<std::size_t>(k)];
    if (i > j) continue;  // a pair across chunks is seen by both owners
    const double *p = w.p.data() + 4L * i, *o = w.p.data() + 4L * j;
    const double d = norm(box.nearest({p[0] - o[0], p[1] - o[1], p[2] - o[2]}));
    const double share = (p[3] + o[3] - d) / fmin2(p[3], o[3]);
    const ParticleId a = w.id[i], b = w.id[j];
    offer(Watch::overlap, share, m.warn_overlap, a < b ? a : b, a < b ? b : a);
  }
  for (const WallState& t : c.wall_state) {
    const double r = w.p[4L * t.row + 3];
    const ParticleId id = w.id[t.row], wall = -2 - t.contact.wall;
    offer(Watch::overlap, (r - t.contact.distance) / r, m.warn_overlap, id, wall);
    offer(Watch::travel, norm(t.contact.velocity) * dt / r, m.warn_travel, id, wall);
  }
  c.extremes = x;
}

void judge_walls(World& w) {
  const WallSet::StepTravel t = w.walls.step_travel();
  if (!(t.distance > w.wall_step) || w.alive == 0) return;
  const double allowed = w.wall_step / w.scene.monitor.max_travel, share = t.distance / allowed;
  fail_step(w, {},
            fmt::format("wall '{}' moves {:.3g} of the smallest radius in one step: it could pass particles unseen",
                        w.walls.name(t.wall), share),
            fmt::format("a time.step of at most {} s, or a larger checks.max_travel",
                        at_most(w.scene.dt * w.scene.monitor.warn_travel / share)));
}

void judge_step(World& w) {
  if (w.chunks.empty() || !w.chunks.front()->extremes.filled) return;
  const MonitorSettings& m = w.scene.monitor;
  const auto overlap = reduced(w, Watch::overlap), travel = reduced(w, Watch::travel),
             stiffness = reduced(w, Watch::stiffness);
  for (const auto& c : w.chunks) c->extremes.filled = false;
  if (travel.value > m.warn_travel) {
    const std::string text =
        travel.partner == -1
            ? fmt::format("particle {} moves {:.3g} of its radius in one step", travel.id, travel.value)
            : fmt::format("{} moves {:.3g} of the radius of particle {} in one step", name_of(w, travel.partner),
                          travel.value, travel.id);
    // Up to one radius per step the centre cannot pass a wall before the contact is seen.
    const std::string cure = fmt::format("a time.step of at most {:.3g} s", w.scene.dt * m.warn_travel / travel.value);
    if (travel.value > m.max_travel)
      fail_step(w, {travel.id}, text + ": it could pass through a wall or a particle unseen",
                cure + ", or a larger checks.max_travel");
    warn(w, "travel", m.warn_travel, travel.value, travel.count, text + "; impacts want " + cure);
  }
  if (overlap.value > m.warn_overlap)
    warn(w, "overlap", m.warn_overlap, overlap.value, overlap.count,
         fmt::format("particle {} and {} overlap by {:.3g} of the smaller radius; stiffer contacts change less of the "
                     "geometry (`talus check` says how stiff)",
                     overlap.id, name_of(w, overlap.partner), overlap.value));
  if (stiffness.value > w.warn_row) {
    const double dt = w.scene.dt, row = stiffness.value / (dt * dt),
                 effective = effective_stiffness(w.scene, w.time_step.ruler, row, dt);
    warn(w, "stiffness", m.warn_stiffness, effective, stiffness.count,
         fmt::format("the contacts of particle {} together are so stiff that step^2 k/m = {:.3g}, with dashpots and "
                     "tangential springs {:.3g}; a time.step of at most {} s is surely stable",
                     stiffness.id, stiffness.value, effective, at_most(step_for_row(w.scene, w.time_step, row, 2))));
  }
  if (w.has.energies && w.start_energy_known && (w.step - 1) % k_energy_every == 0) judge_energy(w);
}

bool finite_row(const World& w, Row i) {
  const double *x = w.p.data() + 4L * i, *v = w.v.data() + static_cast<long>(w.stride) * i;
  double sum = 0;
  for (int k = 0; k < 3; ++k) sum += 0 * x[k] + 0 * v[k];
  if (w.has.rotation)
    for (int k = 4; k < 7; ++k) sum += 0 * v[k];
  return sum == 0;
}

void check_finite(World& w) {
  const Blocks blocks{w.n, static_cast<int>(w.chunks.size())};
  std::vector<Row> bad(w.chunks.size(), -1);  // lowest of each block
  parallel(w, blocks.count, [&](int b) {
    for (auto i = static_cast<Row>(blocks.to(b)); i-- > static_cast<Row>(blocks.from(b));)
      if (!finite_row(w, i)) bad[static_cast<std::size_t>(b)] = i;
  });
  for (const Row i : bad)
    if (i >= 0) fail_non_finite(w, i);
}

void fail_step(World& w, std::vector<ParticleId> ids, const std::string& what, const std::string& cure) {
  if (w.counters.steps > 0 && w.velocity_at_old_step) {
    std::swap(w.p, w.p2);
    std::swap(w.v, w.v2);
    w.velocity_at_old_step = false;
    w.work = w.work_before;
    w.planes.take_back();
    --w.step;
    --w.counters.steps;
    if (w.has.walls) w.walls.set_step(w.step, w.scene.dt);
  }
  for (const auto& c : w.chunks) {
    c->deep_slot = c->deep_wall = -1;
    c->unstable_row = -1;
    c->out_count = 0;
    c->extremes.filled = false;
  }
  w.lists_valid = false;
  w.culprits = std::move(ids);
  throw Error(ErrorCode::physics, what, "step " + std::to_string(w.step), cure);
}

void fail_non_finite(World& w, Row row) {
  const ParticleId id = w.id[row];
  std::string partners;
  const std::vector<std::string> names = touching(w, row);
  for (std::size_t k = 0; k < names.size() && k < 6; ++k) partners += (k == 0 ? " in contact with " : ", ") + names[k];
  if (names.size() > 6) partners += fmt::format(" and {} more", names.size() - 6);
  fail_step(w, {id}, fmt::format("particle {}{} gets a non-finite position or velocity", id, partners),
            "reduce the time step, check stiffness and initial overlaps");
}

}  // namespace talus
