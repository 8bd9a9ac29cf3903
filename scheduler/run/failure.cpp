// See failure.hpp.
#include "scheduler/run/failure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "core/base/error.hpp"
#include "core/io/atomic_file.hpp"

namespace talus {

void write_neighbourhood(const Simulation& simulation, const std::string& path) {
  if (simulation.culprits().empty()) return;
  Frame f;
  try {
    f = simulation.frame({.contacts = true});
  } catch (const Error&) {
    f = simulation.frame({});  // contacts of a particle outside the domain cannot be formed
  }
  const auto row_of = [&f](ParticleId id) { return std::lower_bound(f.id.begin(), f.id.end(), id) - f.id.begin(); };
  const auto culprit = static_cast<std::size_t>(row_of(simulation.culprits().front()));
  if (culprit >= f.id.size() || f.id[culprit] != simulation.culprits().front()) return;
  const Box box = simulation.scene().domain.box();
  const auto distance = [&](std::size_t k) { return norm(box.nearest(f.x[k] - f.x[culprit])); };
  std::multimap<ParticleId, std::string> touches;
  for (const ContactRecord& c : f.contacts) {
    const auto note = [&](ParticleId who, const std::string& partner) {
      const auto k = static_cast<std::size_t>(row_of(who));
      touches.emplace(who, fmt::format("{}:{:.4g}", partner, c.overlap / f.r[k]));
    };
    note(c.a, c.b >= 0 ? fmt::format("{}", c.b) : fmt::format("wall {}", -1 - c.b));
    if (c.b >= 0) note(c.b, fmt::format("{}", c.a));
  }
  const double reach = 4 * *std::max_element(f.r.begin(), f.r.end());
  std::vector<std::pair<double, std::size_t>> near;
  for (std::size_t k = 0; k < f.id.size(); ++k)
    if (const double d = distance(k); d - f.r[k] - f.r[culprit] <= reach) near.emplace_back(d, k);
  std::sort(near.begin(), near.end());
  std::string text =
      fmt::format("# step {}, t = {:.17g} s\nid,x,y,z,radius,vx,vy,vz,distance,touches\n", f.step, f.time);
  for (const auto& [d, k] : near) {
    std::string partners;
    const auto [from, to] = touches.equal_range(f.id[k]);
    for (auto t = from; t != to; ++t) partners += (partners.empty() ? "" : " ") + t->second;
    text += fmt::format("{},{},{},{},{},{},{},{},{},{}\n", f.id[k], f.x[k].x, f.x[k].y, f.x[k].z, f.r[k], f.v[k].x,
                        f.v[k].y, f.v[k].z, d, partners);
  }
  write_file_atomic(path, text);
}

}  // namespace talus
