// See scene_changes.hpp.
#include "core/scene/scene_changes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <stdexcept>

#include "core/base/det_math.hpp"
#include "core/scene/key.hpp"
#include "core/scene/scene_file.hpp"

namespace talus {
namespace {

/// The value of a key that is not given: its default, if that is a value, else words.
std::string default_value(const std::string& section, const std::string& name) {
  const SceneKey* key = find_scene_key(section, name);
  if (key == nullptr || key->required()) return "(none)";
  return key->fallback;
}

/// Equal values may be written differently in the table of defaults and in a scene.
bool same_value(const SceneValue& value, const std::string& fallback) {
  if (value.value == fallback) return true;
  const auto packed = [](std::string s) {
    s.erase(std::remove(s.begin(), s.end(), ' '), s.end());
    return s;
  };
  return packed(value.value) == packed(fallback);
}

using ByPath = std::map<std::string, SceneValue>;

ByPath by_path(const std::vector<SceneValue>& values) {
  ByPath map;
  for (const SceneValue& v : values) map.emplace(v.path, v);
  return map;
}

/// Values of the scene before: the record knows best what the state depends on, the folder knows the rest.
std::vector<SceneValue> values_before(const SceneBefore& before) {
  if (!before.record) return before.folder->values;
  std::vector<SceneValue> all = before.record->values;
  if (!before.folder) return all;
  for (const SceneValue& v : before.folder->values)
    if (resume_rule(v.section, v.name).rule == AtResume::free) all.push_back(v);
  return all;
}

/// What more than one key together decides.
class Judge {
 public:
  Judge(const Scene& before, const Scene& after, std::int64_t step) : before_(before), after_(after), step_(step) {
    past_differs_ = past_events(before) != past_events(after);
  }

  ResumeRule rule(const SceneValue& value) const {
    const std::string& section = value.section;
    const ResumeRule table = resume_rule(section, value.name);
    if (value.name == "friction" && before_.contact.friction != after_.contact.friction)
      return fixed_by("with or without friction, the state has other columns");
    if (value.name == "twisting_friction" && before_.contact.twisting != after_.contact.twisting)
      return fixed_by("with or without twisting resistance, the state has other columns");
    if ((section == "source" || section == "source.region") && table.rule == AtResume::physics && !stream(value))
      return fixed_by("only a stream can deliver differently from now on");
    if (section == "event" && past_differs_) return fixed_by("an event that has happened cannot be changed");
    if (value.name == "every" && within_a_step(section)) {
      said_ = fmt::format(
          "the state is within a step of this length: first go on to step {}, which lies between two of "
          "both lengths, with the former values (--steps {})",
          between(section), between(section));
      return fixed_by(said_);
    }
    if (section == "output" && value.name == "energies")
      return after_.output.energies ? fixed_by("the balance has to begin with the run") : k_free;
    if (section == "output.plane" && before_.output.flux_planes.empty()) return k_free;
    return table;
  }

 private:
  using Past = std::vector<std::vector<double>>;
  /// Events before the step, in the order in which they happen.
  Past past_events(const Scene& scene) const {
    std::vector<Event> events = scene.events;
    std::stable_sort(events.begin(), events.end(), [](const Event& a, const Event& b) { return a.time < b.time; });
    Past past;
    for (const Event& e : events) {
      if (!(e.time / scene.dt < 9e15) || det::nearest(e.time / scene.dt) >= step_) continue;
      past.push_back({e.time, static_cast<double>(e.action), static_cast<double>(e.group), e.vector.x, e.vector.y,
                      e.vector.z, e.spin.x, e.spin.y, e.spin.z});
    }
    return past;
  }
  /// The value belongs to a source that is and was a stream.
  bool stream(const SceneValue& value) const {
    const std::size_t from = std::string_view("source.").size();
    const auto at =
        static_cast<std::size_t>(std::stoul("0" + value.path.substr(from, value.path.find('.', from) - from)));
    const auto is_stream = [&](const Scene& s) {
      return at < s.sources.size() && s.sources[at].kind == Source::Kind::stream;
    };
    return is_stream(before_) && is_stream(after_);
  }

  /// Heat, conversion and gas sum over `every` steps, which the state is in the middle of.
  static std::int64_t length(const std::string& section, const Scene& s) {
    return section == "heat"         ? s.heat.every
           : section == "conversion" ? s.conversion.every
           : section == "gas"        ? s.gas.every
                                     : 1;
  }
  bool within_a_step(const std::string& section) const {
    return step_ % length(section, before_) != 0 || step_ % length(section, after_) != 0;
  }
  /// The next step at which one of either length ends.
  std::int64_t between(const std::string& section) const {
    const std::int64_t both = std::lcm(length(section, before_), length(section, after_));
    return (step_ / both + 1) * both;
  }

  const Scene &before_, &after_;
  std::int64_t step_;
  bool past_differs_ = false;
  mutable std::string said_;  ///< of the rule given last
};

std::string shortened(const std::string& s) { return s.size() > 60 ? s.substr(0, 57) + "..." : s; }

bool same_shape(const WallSpec& a, const WallSpec& b) {
  const auto same = [](Vec3 p, Vec3 q) { return p.x == q.x && p.y == q.y && p.z == q.z; };
  return a.shape == b.shape && same(a.point, b.point) && same(a.normal, b.normal) && same(a.axis, b.axis) &&
         a.length == b.length && a.radius == b.radius && a.radius_end == b.radius_end && same(a.lower, b.lower) &&
         same(a.upper, b.upper) && a.file == b.file && a.scale == b.scale && same(a.shift, b.shift);
}

}  // namespace

ResumeRule resume_rule(std::string_view section, std::string_view name) {
  const SceneKey* key = find_scene_key(section, name);
  if (key == nullptr)
    throw std::logic_error("no such key of a scene: " + std::string(section) + "." + std::string(name));
  return key->resume;
}

SceneText read_scene_text(std::string_view text, const std::string& name, const std::string& directory,
                          const std::vector<std::string>& overrides) {
  return {parse_scene(text, name, directory, overrides), SceneTable::parse(text, name, overrides).values()};
}

std::string scene_record(const SceneText& scene) {
  std::string text, place;
  for (const SceneValue& v : scene.values) {
    const bool length = v.section == "time" && v.name != "step";
    if (resume_rule(v.section, v.name).rule == AtResume::free && !length) continue;
    const std::string here = v.path.substr(0, v.path.size() - v.name.size());
    if (here != place)
      text += (find_scene_section(v.section)->repeated ? "[[" + v.section + "]]\n" : "[" + v.section + "]\n");
    place = here;
    // How long the run was to be is no part of the state.
    if (length) continue;
    text += fmt::format("{} = {}\n", v.name, v.value);
    if (v.section == "time") text += "steps = 0\n";
  }
  return text + contents_text(contents_of(scene.scene));
}

namespace {

/// Keys that name the same file as before, which holds something else now.
void add_changed_files(const std::vector<FileContent>& before, const SceneText& after, const Judge& judge,
                       const ByPath& old_values, std::vector<SceneChange>& changes) {
  if (before.empty()) return;
  for (const FileContent& now : contents_of(after.scene)) {
    const auto same_path = [&](const auto& x) { return x.path == now.path; };
    const auto old = std::find_if(before.begin(), before.end(), same_path);
    const auto value = old_values.find(now.path);
    if (old == before.end() || old->sum == now.sum || value == old_values.end()) continue;
    if (std::any_of(changes.begin(), changes.end(), same_path)) continue;  // another file
    const ResumeRule rule = judge.rule(value->second);
    changes.push_back(
        {now.path, value->second.value, "the same file with another content", rule.rule, std::string(rule.why), true});
  }
}

}  // namespace

std::vector<SceneChange> scene_changes(const SceneBefore& before, const SceneText& after, std::int64_t step) {
  std::vector<SceneChange> changes;
  if (!before.record && !before.folder) return changes;
  const Judge judge(before.record ? before.record->scene : before.folder->scene, after.scene, step);
  const ByPath old_values = by_path(values_before(before)), new_values = by_path(after.values);
  ByPath all = old_values;
  all.insert(new_values.begin(), new_values.end());
  for (const auto& [path, value] : all) {
    const auto a = old_values.find(path), b = new_values.find(path);
    const ResumeRule rule = judge.rule(value);
    if (value.section == "time" && value.name != "step") continue;                                  // compared as steps
    if (!before.folder && resume_rule(value.section, value.name).rule == AtResume::free) continue;  // not recorded
    const std::string fallback = default_value(value.section, value.name);
    if (a != old_values.end() && b != new_values.end() ? a->second.value == b->second.value
                                                       : same_value(value, fallback))
      continue;
    changes.push_back({path, a != old_values.end() ? a->second.value : fallback,
                       b != new_values.end() ? b->second.value : fallback, rule.rule, std::string(rule.why)});
  }
  add_changed_files(before.contents, after, judge, old_values, changes);
  if (before.folder && before.folder->scene.steps != after.scene.steps)
    changes.push_back({"time.steps", std::to_string(before.folder->scene.steps), std::to_string(after.scene.steps),
                       AtResume::free, ""});
  std::stable_sort(changes.begin(), changes.end(), [](const SceneChange& x, const SceneChange& y) {
    return (x.rule == AtResume::fixed) > (y.rule == AtResume::fixed);
  });
  return changes;
}

std::vector<int> wall_numbers(const Scene& before, const Scene& after, const std::vector<SceneChange>& changes) {
  std::vector<int> numbers;
  bool same = before.walls.size() == after.walls.size();
  for (std::size_t a = 0; a < before.walls.size(); ++a) {
    int found = -1;
    const std::string file = fmt::format("wall.{}.file", a);
    const bool other =
        std::any_of(changes.begin(), changes.end(), [&](const SceneChange& c) { return c.content && c.path == file; });
    for (std::size_t b = 0; !other && b < after.walls.size(); ++b)
      if (after.walls[b].name == before.walls[a].name && same_shape(after.walls[b], before.walls[a]))
        found = static_cast<int>(b);
    same = same && found == static_cast<int>(a);
    numbers.push_back(found);
  }
  int sides = 0;  // the same ones: the domain is fixed
  for (const auto& axis : after.domain.boundary)
    for (const Boundary side : axis) sides += side == Boundary::wall ? 1 : 0;
  for (int k = 0; k < sides; ++k) numbers.push_back(static_cast<int>(after.walls.size()) + k);
  return same ? std::vector<int>{} : numbers;
}

std::string change_text(const SceneChange& c) {
  return fmt::format("{}: {} -> {}", c.path, shortened(c.before), shortened(c.after));
}

}  // namespace talus
