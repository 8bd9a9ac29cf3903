// summary.json; see summary.hpp.
#include "core/io/summary.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

#include <cmath>

#include "core/base/error.hpp"
#include "core/base/text.hpp"
#include "core/io/atomic_file.hpp"
#include "core/io/json_text.hpp"

namespace talus {

namespace {

class Object {
 public:
  void raw(const char* key, const std::string& value) {
    text_ += fmt::format("{}  \"{}\": {}", text_.empty() ? "" : ",\n", key, value);
  }
  void add(const char* key, const std::string& v) { raw(key, json_string(v)); }
  void add(const char* key, double v) { raw(key, number(v)); }
  void add(const char* key, std::int64_t v) { raw(key, fmt::format("{}", v)); }
  void add(const char* key, std::uint64_t v) { raw(key, fmt::format("{}", v)); }
  void add(const char* key, int v) { raw(key, fmt::format("{}", v)); }
  template <class T>
  void add(const char* key, const std::optional<T>& v) {
    v ? add(key, *v) : raw(key, "null");
  }
  static std::string number(double v) { return std::isfinite(v) ? fmt::format("{}", v) : "null"; }
  std::string take() { return "{\n" + text_ + "\n}\n"; }

 private:
  std::string text_;
};

std::string vector(Vec3 a) {
  return fmt::format("[{}, {}, {}]", Object::number(a.x), Object::number(a.y), Object::number(a.z));
}

/// Entries, each on a line of its own, between brackets.
std::string listed(const std::vector<std::string>& entries, const char* brackets) {
  if (entries.empty()) return brackets;
  return fmt::format("{}\n    {}\n  {}", brackets[0], fmt::join(entries, ",\n    "), brackets[1]);
}

/// `text` of each of some things.
template <class Things, class Text>
std::vector<std::string> each(const Things& things, const Text& text) {
  std::vector<std::string> entries;
  for (const auto& t : things) entries.push_back(text(t));
  return entries;
}

std::string mesh_text(const std::pair<std::string, MeshReport>& mesh) {
  const auto& [wall, r] = mesh;
  return fmt::format(
      "{{\"wall\": {}, \"file\": {}, \"facets\": {}, \"facets_read\": {}, \"degenerate\": {}, \"duplicate\": {}, "
      "\"open_edges\": {}, \"forked_edges\": {}, \"flipped\": {}, \"parts\": {}, \"watertight\": {}, \"volume\": {}, "
      "\"lower\": {}, \"upper\": {}, \"rounding\": {}}}",
      json_string(wall), json_string(r.file), r.facets_read - r.dropped(), r.facets_read, r.degenerate, r.duplicate,
      r.open_edges, r.forked_edges, r.flipped, r.parts, r.watertight, r.watertight ? Object::number(r.volume) : "null",
      vector(r.lower), vector(r.upper), Object::number(r.rounding));
}

std::string node_text(const Summary::Node& n) {
  return fmt::format("{{\"name\": {}, \"calls\": {}, \"seconds\": {}}}", json_string(n.name), n.calls,
                     Object::number(n.seconds));
}

std::string plane_text(const Summary::Plane& p) {
  return fmt::format("{{\"name\": {}, \"particles\": {}, \"mass\": {}, \"forward\": {}, \"backward\": {}}}",
                     json_string(p.name), p.particles, Object::number(p.mass), p.forward, p.backward);
}

std::string part_text(const std::pair<std::string, double>& p) {
  return fmt::format("{}: {}", json_string(p.first), Object::number(p.second));
}

std::string rebuild_text(const Summary::Rebuild& r) {
  return fmt::format("[{}, {}, {}, {}, {}, {}, {}]", r.step, r.interval, Object::number(r.k), Object::number(r.floor),
                     Object::number(r.skin), r.pairs, r.contacts);
}

std::string warning_text(const Summary::Alert& w) {
  return fmt::format("{{\"kind\": {}, \"count\": {}, \"first_step\": {}, \"worst\": {}, \"level\": {}, \"text\": {}}}",
                     json_string(w.kind), w.count, w.first_step, Object::number(w.worst), Object::number(w.level),
                     json_string(w.text));
}

void add_run(Object& o, const Summary& s) {
  o.add("title", s.title);
  o.add("scene_file", s.scene_file);
  o.add("version", s.version);
  o.add("status", s.status);
  o.add("particles", s.particles);
  o.add("steps", s.steps);
  o.add("first_step", s.first_step);
  o.add("last_step", s.last_step);
  o.add("dt", s.dt);
  o.add("simulated_time", s.simulated_time);
  o.add("wall_s", s.wall_s);
  o.add("particle_steps_per_s", s.particle_steps_per_s);
  o.raw("nodes", listed(each(s.nodes, node_text), "[]"));
}

void add_counts(Object& o, const Summary& s) {
  o.add("rebuilds", s.rebuilds);
  if (s.cuts) o.add("cuts", *s.cuts);
  o.add("rebuilds_skin", s.rebuilds_skin);
  o.add("rebuilds_forced", s.rebuilds_forced);
  o.add("shortest_interval", s.shortest_interval);
  o.add("mean_interval", s.mean_interval);
  o.raw("rebuild_steps", fmt::format("[{}]", fmt::join(s.rebuild_steps, ", ")));
  o.add("sort_epochs", s.sort_epochs);
  o.add("candidate_pairs", s.candidate_pairs);
  o.add("contacts", s.contacts);
  o.add("wall_contacts", s.wall_contacts);
  if (s.solved_pairs) o.add("solved_pairs", *s.solved_pairs);
  if (s.safe_pairs) o.add("safe_pairs", *s.safe_pairs);
  o.add("inserted", s.inserted);
  o.add("removed", s.removed);
  o.add("removed_mass", s.removed_mass);
  if (s.planes_hash) {
    o.raw("planes", listed(each(s.planes, plane_text), "[]"));
    o.add("planes_hash", fmt::format("{:016x}", *s.planes_hash));
  }
  if (!s.parts.empty()) o.raw("parts", listed(each(s.parts, part_text), "{}"));
  o.add("late_detections", s.late_detections);
  o.add("missed_contacts", s.missed_contacts);
  o.add("bytes_per_particle", s.bytes_per_particle);
  o.add("peak_rss_bytes", s.peak_rss_bytes);
}

void add_means(Object& o, const Summary& s) {
  o.raw("list_series_columns", R"(["step", "interval", "k", "floor", "skin", "pairs", "contacts"])");
  o.raw("list_series", listed(each(s.list_series, rebuild_text), "[]"));
  o.add("verlet_k", s.verlet_k);
  o.raw("verlet_k_automatic", s.verlet_k_automatic ? "true" : "false");
  o.add("policy", s.policy);
  o.add("policy_guarantee", s.guarantee);
  o.add("law", s.law);
  o.add("isa", s.isa);
  o.add("threads", s.threads);
  o.add("chunk", s.chunk);
  o.add("seed", s.seed);
}

}  // namespace

std::string json_string(const std::string& s) {
  std::string out = "\"";
  for (std::size_t i = 0; i < s.size();) {
    const auto c = static_cast<unsigned char>(s[i]);
    const std::size_t n = utf8_length(s, i);
    if (n == 0) {
      out += "\\ufffd";
      ++i;
    } else if (n > 1) {
      out.append(s, i, n);
      i += n;
    } else {
      if (c == '"' || c == '\\') {
        out += '\\';
        out += static_cast<char>(c);
      } else if (c == '\n') {
        out += "\\n";
      } else if (c < 0x20 || c == 0x7f) {
        out += fmt::format("\\u{:04x}", c);
      } else {
        out += static_cast<char>(c);
      }
      ++i;
    }
  }
  return out + "\"";
}

std::string summary_json(const Summary& s) {
  Object o;
  add_run(o, s);
  add_counts(o, s);
  add_means(o, s);
  o.add("kinetic_energy", s.kinetic_energy);
  o.add("kinetic_rotation", s.kinetic_rotation);
  o.add("potential_energy", s.potential_energy);
  o.add("elastic_energy", s.elastic_energy);
  o.add("dissipated_energy", s.dissipated_energy);
  o.raw("warnings", listed(each(s.warnings, warning_text), "[]"));
  o.raw("meshes", listed(each(s.meshes, mesh_text), "[]"));
  o.add("state_hash", fmt::format("{:016x}", s.state_hash));
  return o.take();
}

void write_summary(const std::string& path, const Summary& summary) { write_file_atomic(path, summary_json(summary)); }

std::string read_summary_text(const std::string& path) {
  std::string text = read_file_text(path);
  if (const auto at = json_error(text))
    throw Error(ErrorCode::io, fmt::format("summary is truncated or damaged at byte {} of {}", *at, text.size()), path,
                "the checkpoints of the run are unaffected");
  // The first and the last key that every summary has.
  if (text.find("\"title\":") == std::string::npos || text.find("\"state_hash\":") == std::string::npos)
    throw Error(ErrorCode::io, "is not the summary of a run", path, "give the summary.json that `talus run` wrote");
  return text;
}

std::int64_t peak_rss_bytes() {
  rusage u{};
  getrusage(RUSAGE_SELF, &u);
  return static_cast<std::int64_t>(u.ru_maxrss) * 1024;
}

}  // namespace talus
