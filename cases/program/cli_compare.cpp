// `talus compare A B`: are two states the same, bit for bit, and if not, where do they first differ and by how much.
// A and B are checkpoints or run folders (their newest checkpoint); each is read through the scene stored beside it.
// Two run folders with particle frames are also compared frame by frame: how the difference grows.
// Exit code 0 where everything compared is equal, 1 where anything differs.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <optional>

#include "cases/program/cli.hpp"
#include "cases/program/cli_compare_growth.hpp"
#include "cases/program/cli_console.hpp"
#include "cases/program/cli_folder.hpp"
#include "cases/program/cli_json.hpp"
#include "core/io/particle_frames.hpp"
#include "scheduler/simulation.hpp"

namespace talus::cli {
namespace {

struct State {
  std::string path;
  Frame frame;
  std::uint64_t hash = 0;
};

State read_state(const std::string& path, const RunOptions& engine) {
  const Stored stored = open_stored(path);
  const Simulation simulation(stored.scene, engine, stored.checkpoint);
  return {stored.checkpoint.path(), simulation.frame({}), simulation.state_hash()};
}

/// Differences of one field over the particles that both states hold.
struct FieldDifference {
  std::string name;
  std::int64_t count = 0;  ///< particles with other bits
  double largest = 0;      ///< max |a - b| over components, in the field's unit
  ParticleId first = -1, worst = -1;
};

void note(FieldDifference& d, ParticleId id, double a, double b, bool& counted) {
  if (same_bits(a, b)) return;
  if (!counted) ++d.count;
  counted = true;
  if (d.first < 0) d.first = id;
  const double size = std::fabs(a - b);
  // NaN counts as infinitely different, or it would never be shown.
  const double value = std::isnan(size) ? HUGE_VAL : size;
  if (d.worst < 0 || value > d.largest) d.largest = value, d.worst = id;
}

struct Comparison {
  std::int64_t common = 0, only_a = 0, only_b = 0;
  ParticleId first_only = -1;
  std::vector<FieldDifference> fields;
};

/// How bodies that are no spheres lie, which the places of their spheres do not always tell.
FieldDifference compare_orientations(const Frame& a, const Frame& b) {
  FieldDifference d{"orientation"};
  for (std::size_t i = 0, j = 0; i < a.bodies.size() && j < b.bodies.size();) {
    if (a.bodies[i].id != b.bodies[j].id) {
      ++(a.bodies[i].id < b.bodies[j].id ? i : j);
      continue;
    }
    bool counted = false;
    for (std::size_t k = 0; k < 4; ++k)
      note(d, a.bodies[i].id, a.bodies[i].orientation[k], b.bodies[j].orientation[k], counted);
    ++i, ++j;
  }
  return d;
}

Comparison compare_frames(const Frame& a, const Frame& b) {
  Comparison c;
  c.fields = {{"position [m]"}, {"velocity [m/s]"}, {"spin [rad/s]"}, {"radius [m]"}, {"material"}};
  const std::size_t own = c.fields.size();
  const ColumnPairs columns = common_columns(a, b);
  for (const auto& [e, f] : columns) c.fields.push_back({e->name + (e->unit.empty() ? "" : " [" + e->unit + "]")});
  const bool spin = !a.w.empty() && !b.w.empty();
  const bool material = !a.material.empty() && !b.material.empty();
  const auto vector = [](FieldDifference& d, ParticleId id, Vec3 p, Vec3 q) {
    bool counted = false;
    for (int k = 0; k < 3; ++k) note(d, id, p[k], q[k], counted);
  };
  const auto lonely = [&](std::int64_t& count, ParticleId id) {
    ++count;
    if (c.first_only < 0 || id < c.first_only) c.first_only = id;
  };
  std::size_t i = 0, j = 0;
  while (i < a.id.size() || j < b.id.size()) {  // frames are in id order: one merge
    if (j == b.id.size() || (i < a.id.size() && a.id[i] < b.id[j])) {
      lonely(c.only_a, a.id[i++]);
      continue;
    }
    if (i == a.id.size() || b.id[j] < a.id[i]) {
      lonely(c.only_b, b.id[j++]);
      continue;
    }
    ++c.common;
    const ParticleId id = a.id[i];
    vector(c.fields[0], id, a.x[i], b.x[j]);
    vector(c.fields[1], id, a.v[i], b.v[j]);
    if (spin) vector(c.fields[2], id, a.w[i], b.w[j]);
    bool counted = false;
    note(c.fields[3], id, a.r[i], b.r[j], counted);
    counted = false;
    if (material) note(c.fields[4], id, a.material[i], b.material[j], counted);
    for (std::size_t k = 0; k < columns.size(); ++k) {
      counted = false;
      note(c.fields[own + k], id, columns[k].first->values[i], columns[k].second->values[j], counted);
    }
    ++i, ++j;
  }
  if (!a.bodies.empty() && !b.bodies.empty()) c.fields.push_back(compare_orientations(a, b));
  return c;
}

/// Lowest id that differs in any way, with the field; empty name where none does.
std::pair<ParticleId, std::string> first_difference(const Comparison& c) {
  std::pair<ParticleId, std::string> first{-1, ""};
  const auto offer = [&](ParticleId id, const std::string& name) {
    if (id >= 0 && (first.first < 0 || id < first.first)) first = {id, name};
  };
  offer(c.first_only, "present in one state only");
  for (const auto& f : c.fields) offer(f.first, f.name);
  return first;
}

/// Frame by frame, where both are run folders that hold particle frames.
std::optional<Growth> growth_of(const std::string& a, const std::string& b) {
  namespace fs = std::filesystem;
  if (!fs::is_directory(a) || !fs::is_directory(b)) return {};
  const auto first = ParticleFrames::find(a), second = ParticleFrames::find(b);
  if (!first || !second) return {};
  return compare_growth(*first, *second, stored_scene(RunFolder::open(a)).domain);
}

void add_growth(Json& j, const Growth& g) {
  j.begin_object("growth").add("frames_equal", g.equal()).add("radius", g.radius);
  if (!g.equal()) j.add("first_difference_time", g.first_time);
  if (g.fitted >= 3) j.add("rate", g.rate).add("fit_quality", g.quality);
  if (g.horizon >= 0) j.add("horizon", g.horizon);
  j.begin_array("frames");
  for (const GrowthPoint& p : g.points) {
    j.begin_object().add("time", p.time).add("step_a", p.step_a).add("step_b", p.step_b).add("common", p.common);
    j.add("different", p.different).add("rms", p.rms).add("max", p.max).add("rms_velocity", p.rms_velocity);
    j.add("max_velocity", p.max_velocity).add("first_id", p.first).add("worst_id", p.worst).end_object();
  }
  j.end_array().end_object();
}
}  // namespace

int compare(const Options& options) {
  const State a = read_state(options.files.at(0), options.run), b = read_state(options.files.at(1), options.run);
  const Comparison c = compare_frames(a.frame, b.frame);
  const auto [id, field] = first_difference(c);
  const std::optional<Growth> growth = growth_of(options.files.at(0), options.files.at(1));
  const bool equal = a.hash == b.hash && a.frame.step == b.frame.step && id < 0 && (!growth || growth->equal());
  if (options.json) {
    Json j;
    j.begin_object().add("equal", equal).begin_array("states");
    for (const State* s : {&a, &b}) {
      j.begin_object().add("file", s->path).add("step", s->frame.step);
      j.add("particles", static_cast<std::int64_t>(s->frame.id.size()));
      j.add("state_hash", fmt::format("{:016x}", s->hash)).end_object();
    }
    j.end_array().add("common", c.common).add("only_in_first", c.only_a).add("only_in_second", c.only_b);
    if (id >= 0) j.add("first_difference_id", id).add("first_difference_field", field);
    j.begin_array("fields");
    for (const auto& f : c.fields) {
      j.begin_object().add("field", f.name).add("particles", f.count).add("max_difference", f.largest);
      j.add("at_id", f.worst).end_object();
    }
    j.end_array();
    if (growth) add_growth(j, *growth);
    put("{}\n", j.end_object().text());
    return equal ? 0 : 1;
  }
  for (const State* s : {&a, &b}) {
    put("{}  step {}, {} particles, state hash {:016x}\n", shown_path(s->path), s->frame.step,
        grouped(s->frame.id.size()), s->hash);
  }
  if (equal) {
    put("equal, bit for bit{}\n", growth ? fmt::format(" (and so are {} common frames)", growth->points.size()) : "");
    return 0;
  }
  if (a.frame.step != b.frame.step) put("the states are of different steps\n");
  if (c.only_a + c.only_b > 0) put("only in the first: {}, only in the second: {}\n", c.only_a, c.only_b);
  if (id >= 0) {
    put("first difference: particle {}, {}\n", id, field);
  } else if (a.hash != b.hash && a.frame.step == b.frame.step) {
    put("particles are equal; the hidden state (contact history, sources) differs\n");
  }
  for (const auto& f : c.fields) {
    if (f.count > 0) {
      put("  {:<15} {} particles differ, at most {:.3e} (particle {})\n", f.name, grouped(f.count), f.largest, f.worst);
    }
  }
  if (growth) put("{}", growth_text(*growth));
  return 1;
}

}  // namespace talus::cli
