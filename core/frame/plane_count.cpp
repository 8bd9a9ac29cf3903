// Flux planes; see plane_count.hpp.
#include "core/frame/plane_count.hpp"

#include <xxhash.h>

#include <array>
#include <cstring>
#include <utility>

#include "core/base/error.hpp"

namespace talus {

CountedPlane::CountedPlane(const Domain& domain, const OutputSettings::Plane& plane)
    : normal_(plane.normal), size_(domain.upper - domain.lower), half_{k_never, k_never, k_never} {
  int first = 0, across = 0;
  for (int k = 2; k >= 0; --k)
    if (normal_[k] != 0) {
      first = k;
      ++across;
    }
  if (normal_[first] < 0) {
    sign_ = -1;
    normal_ = -1.0 * normal_;
  }
  const Vec3 point = plane.point - domain.lower;
  axis_ = across == 1 ? first : -1;
  offset_ = axis_ >= 0 ? point[axis_] : (normal_.x * point.x + normal_.y * point.y) + normal_.z * point.z;
  for (int k = 0; k < 3; ++k)
    if (domain.periodic(k) && normal_[k] != 0) {
      half_[k] = 0.5 * size_[k];
      periodic_ = true;
    }
}

bool CountedPlane::meets() const noexcept {
  if (axis_ >= 0) return offset_ >= 0 && offset_ <= size_[axis_];
  double least = 0, most = 0;
  for (int k = 0; k < 3; ++k) (normal_[k] < 0 ? least : most) += normal_[k] * size_[k];
  return offset_ >= least && offset_ <= most;
}

/// How the side changes in the jumps from one end of a periodic axis to the other, which are no passages.
int CountedPlane::jumps(const double* a, const double* b) const noexcept {
  struct Jump {
    int axis;
    double time;  ///< share of the step
    bool upwards;
  };
  std::array<Jump, 3> jump;
  int n = 0;
  Vec3 way;
  for (int k = 0; k < 3; ++k) {
    way[k] = b[k] - a[k];
    if (!(std::abs(way[k]) > half_[k])) continue;
    const bool upwards = way[k] < 0;  // it left at the upper end
    way[k] += upwards ? size_[k] : -size_[k];
    jump[static_cast<std::size_t>(n++)] = {k, ((upwards ? size_[k] : 0.0) - a[k]) / way[k], upwards};
  }
  int sum = 0;
  if (axis_ >= 0) {
    for (int q = 0; q < n; ++q) sum += jump[static_cast<std::size_t>(q)].upwards ? -1 : 1;
    return sum;
  }
  for (const auto& [l, r] : {std::pair<std::size_t, std::size_t>{0, 1}, {1, 2}, {0, 1}})  // in order of time
    if (static_cast<int>(r) < n && jump[r].time < jump[l].time) std::swap(jump[l], jump[r]);
  Vec3 shift;
  for (int q = 0; q < n; ++q) {
    const Jump& j = jump[static_cast<std::size_t>(q)];
    double out[3], in[3];
    for (int k = 0; k < 3; ++k) out[k] = in[k] = a[k] + j.time * way[k] + shift[k];
    out[j.axis] = j.upwards ? size_[j.axis] : 0.0;
    in[j.axis] = j.upwards ? 0.0 : size_[j.axis];
    shift[j.axis] = j.upwards ? -size_[j.axis] : size_[j.axis];
    sum += (side(in) ? 1 : 0) - (side(out) ? 1 : 0);
  }
  return sum;
}

int CountedPlane::passages(const double* a, const double* b) const noexcept {
  int net = (side(b) ? 1 : 0) - (side(a) ? 1 : 0);
  if (periodic_ && wraps(a, b)) net -= jumps(a, b);
  return sign_ * net;
}

PlaneCounts::PlaneCounts(const Scene& scene) : specs_(scene.output.flux_planes), totals_(specs_.size()) {
  for (const auto& plane : specs_) planes_.emplace_back(scene.domain, plane);
  before_ = totals_;
}

void PlaneCounts::add(std::int32_t plane, int net, double mass) noexcept {
  PlaneTotal& t = totals_[static_cast<std::size_t>(plane)];
  (net > 0 ? t.forward : t.backward) += net > 0 ? net : -net;
  t.mass += net * mass;
}

namespace {

/// What precedes the name of a plane in the bytes; no padding, so that bytes are a function of the state.
struct PlaneHeader {
  double point[3], normal[3];
  std::int64_t forward, backward;
  double mass;
  std::uint64_t name_length;
};

bool same(const double* a, Vec3 b) { return a[0] == b.x && a[1] == b.y && a[2] == b.z; }

}  // namespace

std::vector<std::uint8_t> PlaneCounts::save() const {
  static_assert(sizeof(PlaneHeader) == 80);
  std::vector<std::uint8_t> bytes;
  const auto append = [&bytes](const void* data, std::size_t n) {
    const auto* from = static_cast<const std::uint8_t*>(data);
    bytes.insert(bytes.end(), from, from + n);
  };
  for (std::size_t q = 0; q < specs_.size(); ++q) {
    const auto& s = specs_[q];
    const PlaneTotal& t = totals_[q];
    const PlaneHeader h{{s.point.x, s.point.y, s.point.z},
                        {s.normal.x, s.normal.y, s.normal.z},
                        t.forward,
                        t.backward,
                        t.mass,
                        s.name.size()};
    append(&h, sizeof h);
    append(s.name.data(), s.name.size());
  }
  return bytes;
}

void PlaneCounts::load(std::span<const std::uint8_t> bytes, const std::string& where) {
  std::size_t at = 0;
  while (at < bytes.size()) {
    PlaneHeader h{};
    const std::size_t left = bytes.size() - at;
    if (left >= sizeof h) std::memcpy(&h, bytes.data() + at, sizeof h);
    if (left < sizeof h || h.name_length > left - sizeof h)
      throw Error(ErrorCode::io, "section 'planes' has a wrong size", where);
    const std::string name(reinterpret_cast<const char*>(bytes.data() + at + sizeof h), h.name_length);
    at += sizeof h + h.name_length;
    for (std::size_t q = 0; q < specs_.size(); ++q) {
      if (specs_[q].name != name) continue;
      if (!same(h.point, specs_[q].point) || !same(h.normal, specs_[q].normal))
        throw Error(ErrorCode::io, "the plane '" + name + "' has counted at another place or along another normal",
                    where, "give the new plane another name");
      totals_[q] = {h.forward, h.backward, h.mass};
    }
  }
  before_ = totals_;
}

std::uint64_t PlaneCounts::hash() const {
  const std::vector<std::uint8_t> bytes = save();
  return XXH3_64bits(bytes.data(), bytes.size());
}

}  // namespace talus
