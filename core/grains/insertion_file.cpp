// Initial states from files: reading, tiles, and the refusal of overlaps. Who calls it: core/grains/insertion.cpp.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/det_math.hpp"
#include "core/base/error.hpp"
#include "core/grains/file_bodies.hpp"
#include "core/grains/insertion.hpp"
#include "core/grains/occupied.hpp"
#include "core/grains/source_walls.hpp"
#include "core/tables/particle_file.hpp"

namespace talus {
namespace {

std::string source_path(const Scene& scene, const Source& s) {
  if (s.file.starts_with('/') || scene.directory.empty()) return s.file;
  return scene.directory.ends_with('/') ? scene.directory + s.file : scene.directory + "/" + s.file;
}

}  // namespace

void Insertion::read_file(std::size_t s) {
  const Source& source = scene_.sources[s];
  const std::string path = source_path(scene_, source);
  ParticleFile file = read_particle_file(path, scene_.materials, scene_.shapes, source.shape);
  NewParticles& p = files_[s];
  const std::size_t n = file.size();
  const auto check_tiles = [&](std::size_t particles) {
    constexpr std::size_t most = std::numeric_limits<std::int32_t>::max();
    if (tiles(s) <= most / particles) return;
    throw Error(ErrorCode::scene, fmt::format("{} tiles of {} particles are too many", tiles(s), particles),
                fmt::format("source '{}': tile", source.name), fmt::format("allowed: {} particles in all", most));
  };
  check_tiles(n);
  const bool tiled = tiles(s) > 1;
  const Vec3 size = tile_size(s);
  for (std::string& note : file.notes) notes_.push_back(std::move(note));
  if (std::string note = box_note(file, path, scene_.domain.lower, scene_.domain.lower + size); !note.empty())
    notes_.push_back(std::move(note));
  p.fixed = file.fixed.empty() ? std::vector<std::uint8_t>(n) : std::move(file.fixed);
  p.material = file.material.empty() ? std::vector<std::uint8_t>(n, static_cast<std::uint8_t>(source.material))
                                     : std::move(file.material);
  p.group.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    p.group[i] = static_cast<std::int16_t>(source.group);
    for (int k = 0; k < 3; ++k) {
      const double low = scene_.domain.lower[k];
      const double high = source.tile[static_cast<std::size_t>(k)] > 1 ? low + size[k] : scene_.domain.upper[k];
      double& x = file.x[i][k];
      if (x == high && scene_.domain.periodic(k)) x = low;
      if (x >= low && x <= high) continue;
      throw Error(ErrorCode::scene,
                  fmt::format("{} = {} lies outside the {}", "xyz"[k], x, tiled ? "first tile" : "domain"),
                  fmt::format("{}:{}", path, file.row[i]), fmt::format("allowed: {} to {}", low, high));
    }
  }
  take_rows(s, path, file);
  check_tiles(p.size());
}

std::size_t Insertion::tiles(std::size_t s) const {
  std::size_t n = 1;
  for (const int k : scene_.sources[s].tile) n *= static_cast<std::size_t>(k);
  return n;
}

Vec3 Insertion::tile_size(std::size_t s) const {
  Vec3 size;
  for (int k = 0; k < 3; ++k)
    size[k] = (scene_.domain.upper[k] - scene_.domain.lower[k]) / scene_.sources[s].tile[static_cast<std::size_t>(k)];
  return size;
}

/// The file's particles, then its copies: x varies slowest.
void Insertion::append_tiles(std::size_t s, NewParticles& out) const {
  const NewParticles& f = files_[s];
  const std::array<int, 3>& tile = scene_.sources[s].tile;
  const Vec3 size = tile_size(s);
  const auto append = [](auto& to, const auto& more) { to.insert(to.end(), more.begin(), more.end()); };
  for (int a = 0; a < tile[0]; ++a) {
    for (int b = 0; b < tile[1]; ++b) {
      for (int c = 0; c < tile[2]; ++c) {
        const Vec3 shift{a * size.x, b * size.y, c * size.z};
        const auto before = static_cast<std::int32_t>(out.size());
        for (const Vec3& x : f.x) {
          Vec3 y = x + shift;
          // rounding must not carry the last tile through the domain's end
          for (int k = 0; k < 3; ++k) y[k] = fmin2(y[k], scene_.domain.upper[k]);
          out.x.push_back(y);
        }
        append(out.v, f.v);
        append(out.w, f.w);
        append(out.r, f.r);
        append(out.material, f.material);
        append(out.fixed, f.fixed);
        append(out.group, f.group);
        out.source.insert(out.source.end(), f.size(), static_cast<std::int32_t>(s));
        for (NewBody body : f.bodies) {
          body.first += before;
          body.x = body.x + shift;
          for (int k = 0; k < 3; ++k) body.x[k] = fmin2(body.x[k], scene_.domain.upper[k]);
          place_spheres(body, out);
          out.bodies.push_back(body);
        }
      }
    }
  }
}

/// "file:row" of a particle of the initial files, with its tile where there are several.
std::string Insertion::place_in_file(std::size_t particle) const {
  std::size_t s = 0;
  while (particle >= files_[s].size() * tiles(s)) {
    particle -= files_[s].size() * tiles(s);
    ++s;
  }
  const Source& source = scene_.sources[s];
  const std::size_t n = files_[s].size(), copy = particle / n;
  std::string place = fmt::format("{}:{}", source.file, rows_[s][particle % n]);
  if (tiles(s) > 1) {
    const auto ny = static_cast<std::size_t>(source.tile[1]), nz = static_cast<std::size_t>(source.tile[2]);
    place += fmt::format(" (tile {}, {}, {})", copy / (ny * nz), copy / nz % ny, copy % nz);
  }
  return place;
}

namespace {

struct InitialOverlap {
  std::int32_t a, b;  ///< particles, or b = -1 - wall
  double depth, share;
  auto key() const { return std::pair(a, b); }
};

}  // namespace

/// Files come in any order; walking through space in rows of cells keeps the neighbours in the cache.
std::vector<std::int32_t> Insertion::in_rows(const NewParticles& p, double largest) const {
  std::vector<std::pair<std::uint64_t, std::int32_t>> keys(p.size());
  for (std::size_t i = 0; i < p.size(); ++i) {
    std::uint64_t key = 0;
    for (int k = 2; k >= 0; --k) {
      const double c = fmin2((p.x[i][k] - scene_.domain.lower[k]) / (2 * largest), 2097151);
      key = key << 21 | static_cast<std::uint64_t>(det::floor_int(c));
    }
    keys[i] = {key, static_cast<std::int32_t>(i)};
  }
  std::sort(keys.begin(), keys.end());
  std::vector<std::int32_t> order(p.size());
  for (std::size_t n = 0; n < p.size(); ++n) order[n] = keys[n].second;
  return order;
}

void Insertion::check_overlaps(const NewParticles& p, const SourceWalls& walls) const {
  // Beds at rest hold real static overlaps, so a share of the radius is always accepted.
  // A relaxing start takes any overlap except coincident centres, which have no direction to part in.
  const bool relaxes = scene_.relax.steps > 0;
  const double allowed =
      relaxes ? k_never : (scene_.allow_initial_overlap ? scene_.max_overlap : fmin2(0.05, scene_.max_overlap));
  const FileBodies bodies(scene_, p);
  std::vector<InitialOverlap> found;
  double largest = 0;
  for (double r : p.r) largest = fmax2(largest, r);
  Occupied occupied(scene_.domain, scene_.domain.lower, scene_.domain.upper, largest);
  occupied.reserve(p.size() + p.size() / 8);
  constexpr std::size_t enough = 1000;
  for (const std::int32_t index : in_rows(p, largest)) {
    if (found.size() >= enough) break;
    const auto i = static_cast<std::size_t>(index);
    occupied.grid().any(p.x[i], p.r[i], [&](const OverlapGrid::Sphere& s, double d2) {
      const double sum = p.r[i] + s.r;
      if (d2 >= sum * sum) return false;
      double depth = sum - std::sqrt(d2), share = depth / fmin2(p.r[i], s.r);
      if (bodies.any() && !bodies.meet(index, p.x[i], s.index, s.x, depth, share)) return false;
      if (share > allowed || (relaxes && d2 == 0))
        found.push_back({std::min(s.index, index), std::max(s.index, index), depth, share});
      return found.size() >= enough;
    });
    occupied.add(p.x[i], p.r[i], index);
    if (relaxes) continue;  // a wall has a normal also for a centre on its surface
    if (const shapes::Body* body = bodies.surface(index, p.x[i])) {
      const double thickness = bodies.thickness(index);
      if (const auto wall = walls.deepest(*body, p.r[i], allowed * thickness))
        found.push_back({index, -1 - wall->wall, wall->depth, wall->depth / thickness});
    } else if (const auto wall = walls.deepest(p.x[i], p.r[i], allowed * p.r[i]))
      found.push_back({index, -1 - wall->wall, wall->depth, wall->depth / p.r[i]});
  }
  if (found.empty()) return;
  std::sort(found.begin(), found.end(),
            [](const InitialOverlap& q, const InitialOverlap& o) { return q.key() < o.key(); });
  found.erase(std::unique(found.begin(), found.end(),
                          [](const InitialOverlap& q, const InitialOverlap& o) { return q.key() == o.key(); }),
              found.end());
  const auto place = [&](std::int32_t i) {
    return i >= 0 ? place_in_file(static_cast<std::size_t>(i))
                  : fmt::format("wall \"{}\"", walls.walls()->name(-1 - i));
  };
  std::string list;
  for (std::size_t k = 0; k < found.size() && k < 5; ++k)
    list +=
        fmt::format("{}{} and {} by {:.4g} m ({:.3g} of the {})", k == 0 ? "" : "; ", place(found[k].a),
                    place(found[k].b), found[k].depth, found[k].share, found[k].b >= 0 ? "smaller radius" : "radius");
  const std::string count = fmt::format("{}{}", found.size() >= enough ? "at least " : "", found.size());
  if (relaxes)
    throw Error(ErrorCode::scene,
                fmt::format("{} pairs of coincident centres, which have no direction to part in: {}", count, list),
                place(found[0].a), "move one particle of each pair by any amount; [relax] parts them from there");
  throw Error(ErrorCode::scene,
              fmt::format("{} initial overlaps deeper than {:g} of the smaller radius: {}", count, allowed, list),
              place(found[0].a),
              "separate the particles, part them with relax.steps, or set checks.allow_initial_overlap and "
              "checks.max_overlap");
}

}  // namespace talus
