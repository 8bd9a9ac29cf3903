// See velocity_profile.hpp.
#include "scheduler/lists/velocity_profile.hpp"

#include <algorithm>
#include <vector>

#include "scheduler/team/parallel.hpp"

namespace talus {

namespace {

constexpr double k_spacing = 4;  // of the nodes, in largest radii
constexpr int k_most_nodes = 256;

/// Nodes along one axis, and where a coordinate lies between them.
struct Nodes {
  int axis = -1, count = 1;
  double inverse = 0;  // nodes per metre

  Nodes(const Rules& rules, int along) : axis(along) {
    const double n = rules.size[axis] / (k_spacing * rules.r_max);
    count = 1 + (n < 1 ? 1 : (n < k_most_nodes - 1 ? static_cast<int>(n) : k_most_nodes - 1));
    inverse = (count - 1) / rules.size[axis];
  }
  /// Lower node; `fraction`: of the way to the next one.
  int at(const double* x, double& fraction) const {
    const double s = x[axis] * inverse;
    const int k = !(s > 0) ? 0 : (s >= count - 2 ? count - 2 : static_cast<int>(s));
    fraction = std::clamp(s - k, 0.0, 1.0);
    return k;
  }
};

/// Hat-weighted sums at one node.
struct Sum {
  Vec3 velocity;
  double weight = 0;
};

/// Kinetic energy (per mass) that means at the nodes explain.
double explained(const std::vector<Sum>& node) {
  double e = 0;
  for (const Sum& s : node)
    if (s.weight > 0) e += norm2(s.velocity) / s.weight;
  return e;
}

/// Means at the nodes, from the fullest node outwards with no step larger than `most` [m/s]; a node without particles
/// takes its neighbour's.
std::vector<Vec3> bounded_means(const std::vector<Sum>& node, double most) {
  const int n = static_cast<int>(node.size());
  const auto fullest =
      std::max_element(node.begin(), node.end(), [](const Sum& a, const Sum& b) { return a.weight < b.weight; });
  const int middle = static_cast<int>(fullest - node.begin());
  std::vector<Vec3> value(node.size());
  const auto mean = [&](int k) {
    const Sum& s = node[static_cast<std::size_t>(k)];
    return s.weight > 0 ? (1 / s.weight) * s.velocity : Vec3{};
  };
  value[static_cast<std::size_t>(middle)] = mean(middle);
  for (const int direction : {-1, 1})
    for (int k = middle + direction; k >= 0 && k < n; k += direction) {
      const Vec3 before = value[static_cast<std::size_t>(k - direction)];
      Vec3 step = node[static_cast<std::size_t>(k)].weight > 0 ? mean(k) - before : Vec3{};
      const double size = norm(step);
      if (size > most) step = (most / size) * step;
      value[static_cast<std::size_t>(k)] = before + step;
    }
  return value;
}

/// At the nodes of all axes, behind the sum over all rows.
std::vector<Sum> sums_at_nodes(const Rows& rows, const Contacts& contacts, const std::vector<Nodes>& axes, Team& team) {
  // sums by chunk and then over chunks: their order is that of the rows
  const std::size_t chunks = contacts.chunks.size();
  std::vector<std::vector<Sum>> parts(chunks);
  std::size_t nodes = 1;
  for (const Nodes& a : axes) nodes += static_cast<std::size_t>(a.count);
  parallel(team, static_cast<int>(chunks), [&](int q) {
    const Chunk& c = *contacts.chunks[static_cast<std::size_t>(q)];
    std::vector<Sum>& sum = parts[static_cast<std::size_t>(q)];
    sum.resize(nodes);
    for (Row i = c.lo; i < c.hi; ++i) {
      if (!rows.is_alive(i)) continue;
      const double *x = rows.p.data() + 4L * i, *u = rows.v.data() + static_cast<long>(rows.stride) * i;
      const Vec3 v{u[0], u[1], u[2]};
      sum[0].velocity = sum[0].velocity + v;
      sum[0].weight += 1;
      Sum* first = &sum[1];
      for (const Nodes& a : axes) {
        double f = 0;
        Sum* s = first + a.at(x, f);
        s[0].velocity = s[0].velocity + (1 - f) * v;
        s[0].weight += 1 - f;
        s[1].velocity = s[1].velocity + f * v;
        s[1].weight += f;
        first += a.count;
      }
    }
  });
  std::vector<Sum> all(nodes);
  for (const auto& part : parts)
    for (std::size_t k = 0; k < nodes; ++k) {
      all[k].velocity = all[k].velocity + part[k].velocity;
      all[k].weight += part[k].weight;
    }
  return all;
}

}  // namespace

double fit_velocity_profile(const Rules& rules, const Rows& rows, const Contacts& contacts, Lists& lists, Team& team,
                            double life) {
  std::vector<Nodes> axes;
  for (int k = 0; k < 3; ++k)
    if (!rules.scene.domain.periodic(k)) axes.emplace_back(rules, k);
  lists.frame.stretch = 1;
  const std::vector<Sum> all = sums_at_nodes(rows, contacts, axes, team);
  const Nodes* best = nullptr;
  std::vector<Vec3> value;
  double largest = -1;
  std::size_t first = 1;
  for (const Nodes& a : axes) {
    const std::vector<Sum> node(all.begin() + static_cast<std::ptrdiff_t>(first),
                                all.begin() + static_cast<std::ptrdiff_t>(first) + a.count);
    first += static_cast<std::size_t>(a.count);
    const double e = explained(node);
    if (!(e > largest)) continue;
    largest = e;
    best = &a;
    const double most = life > 0 ? (1 - 1 / k_most_stretch) / (life * a.inverse) : 0;
    value = bounded_means(node, most);
  }
  double fastest = 0;
  if (best == nullptr) {
    value.assign(1, all[0].weight > 0 ? (1 / all[0].weight) * all[0].velocity : Vec3{});
  } else {
    double slope = 0;
    for (std::size_t k = 0; k + 1 < value.size(); ++k) slope = fmax2(slope, norm(value[k + 1] - value[k]));
    slope *= best->inverse;
    lists.frame.stretch = 1 / (1 - slope * life * (1 + 1e-9));
  }
  for (const Vec3& u : value) fastest = fmax2(fastest, norm(u));
  parallel(team, contacts.count(), [&](int q) {
    const Chunk& c = contacts[q];
    for (Row i = c.lo; i < c.hi; ++i) {
      Vec3 u = value[0];
      if (best != nullptr && rows.is_alive(i)) {
        double f = 0;
        const auto k = static_cast<std::size_t>(best->at(rows.p.data() + 4L * i, f));
        u = value[k] + f * (value[k + 1] - value[k]);
      }
      for (int k = 0; k < 3; ++k) lists.drift[4L * i + k] = static_cast<float>(u[k]);
    }
  });
  return fastest;
}

}  // namespace talus
