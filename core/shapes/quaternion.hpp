// Unit quaternions as orientations. Who calls it: everything of core/shapes that turns between frames. Invariants: I4.
#pragma once

#include "core/base/types.hpp"

namespace talus::shapes {

/// w + x i + y j + z k; takes vectors of the body's frame to the frame of space.
struct Quaternion {
  double w = 1, x = 0, y = 0, z = 0;
};

inline Quaternion operator*(Quaternion a, Quaternion b) noexcept {
  return {((a.w * b.w - a.x * b.x) - a.y * b.y) - a.z * b.z, ((a.w * b.x + a.x * b.w) + a.y * b.z) - a.z * b.y,
          ((a.w * b.y - a.x * b.z) + a.y * b.w) + a.z * b.x, ((a.w * b.z + a.x * b.y) - a.y * b.x) + a.z * b.w};
}
/// The turn back.
inline Quaternion conjugate(Quaternion q) noexcept { return {q.w, -q.x, -q.y, -q.z}; }
inline Quaternion normalised(Quaternion q) noexcept {
  const double s = 1 / __builtin_sqrt((q.w * q.w + q.x * q.x) + (q.y * q.y + q.z * q.z));
  return {s * q.w, s * q.x, s * q.y, s * q.z};
}

/// Rotation matrix by its rows: to_space multiplies, to_body multiplies by the transpose.
struct Rotation {
  Vec3 row[3];
};
inline Rotation rotation(Quaternion q) noexcept {
  const double xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z, xy = q.x * q.y, xz = q.x * q.z, yz = q.y * q.z;
  const double wx = q.w * q.x, wy = q.w * q.y, wz = q.w * q.z;
  return {{{1 - 2 * (yy + zz), 2 * (xy - wz), 2 * (xz + wy)},
           {2 * (xy + wz), 1 - 2 * (xx + zz), 2 * (yz - wx)},
           {2 * (xz - wy), 2 * (yz + wx), 1 - 2 * (xx + yy)}}};
}
inline Vec3 to_space(const Rotation& r, Vec3 v) noexcept {
  return {dot(r.row[0], v), dot(r.row[1], v), dot(r.row[2], v)};
}
inline Vec3 to_body(const Rotation& r, Vec3 v) noexcept {
  return {(r.row[0].x * v.x + r.row[1].x * v.y) + r.row[2].x * v.z,
          (r.row[0].y * v.x + r.row[1].y * v.y) + r.row[2].y * v.z,
          (r.row[0].z * v.x + r.row[1].z * v.y) + r.row[2].z * v.z};
}

/// The quaternion of a proper rotation matrix, largest component first computed (Shepperd 1978).
inline Quaternion quaternion_of(const Rotation& r) noexcept {
  const double x = r.row[0].x, y = r.row[1].y, z = r.row[2].z, t = x + y + z;
  const double wx = r.row[2].y - r.row[1].z, wy = r.row[0].z - r.row[2].x, wz = r.row[1].x - r.row[0].y;
  const double xy = r.row[0].y + r.row[1].x, xz = r.row[0].z + r.row[2].x, yz = r.row[1].z + r.row[2].y;
  if (t >= x && t >= y && t >= z) return normalised({1 + t, wx, wy, wz});
  if (x >= y && x >= z) return normalised({wx, ((1 + x) - y) - z, xy, xz});
  if (y >= z) return normalised({wy, xy, ((1 - x) + y) - z, yz});
  return normalised({wz, xz, yz, ((1 - x) - y) + z});
}

}  // namespace talus::shapes
