// Basic value types shared by every folder: 3-vectors, aligned columns, index types.
// Invariants: columns are 64-byte aligned, large ones ask for huge pages (first touch decides NUMA placement).
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <new>
#include <vector>

#include "core/base/huge_pool.hpp"

namespace talus {

/// Plain 3-vector of doubles [any SI unit]; arithmetic uses + - * only, in written order (DESIGN I4).
struct Vec3 {
  double x = 0, y = 0, z = 0;
  double& operator[](int k) noexcept { return (&x)[k]; }
  double operator[](int k) const noexcept { return (&x)[k]; }
};
inline Vec3 operator+(Vec3 a, Vec3 b) noexcept { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(Vec3 a, Vec3 b) noexcept { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3 operator-(Vec3 a) noexcept { return {-a.x, -a.y, -a.z}; }
inline Vec3 operator*(double s, Vec3 a) noexcept { return {s * a.x, s * a.y, s * a.z}; }
inline Vec3 operator*(Vec3 a, double s) noexcept { return s * a; }
inline double dot(Vec3 a, Vec3 b) noexcept { return (a.x * b.x + a.y * b.y) + a.z * b.z; }
inline Vec3 cross(Vec3 a, Vec3 b) noexcept {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double norm2(Vec3 a) noexcept { return dot(a, a); }
inline double norm(Vec3 a) noexcept { return __builtin_sqrt(dot(a, a)); }

/// min and max with one fixed rule for equal and signed-zero arguments (DESIGN I4): a < b ? a : b.
inline double fmin2(double a, double b) noexcept { return a < b ? a : b; }
inline double fmax2(double a, double b) noexcept { return a > b ? a : b; }

/// Persistent particle identity; never reused within a run.
using ParticleId = std::int64_t;
/// Storage row of a particle; changes only at sort epochs. int32 keeps pair lists compact (DESIGN 2).
using Row = std::int32_t;

/// Allocator with 64-byte alignment. Arrays above 4 MiB are mappings of their own that ask for huge pages, those from
/// 16 KiB on are cut from such mappings (huge_pool.hpp).
template <class T>
struct AlignedAllocator {
  using value_type = T;
  AlignedAllocator() = default;
  template <class U>
  AlignedAllocator(const AlignedAllocator<U>&) noexcept {}
#ifdef __SANITIZE_ADDRESS__
  static constexpr bool pooled(std::size_t) { return false; }  // every array of malloc's: overruns are seen
  static constexpr bool mapped(std::size_t) { return false; }
#else
  static constexpr bool pooled(std::size_t bytes) { return bytes >= k_pool_smallest && bytes <= k_pool_largest; }
  static constexpr bool mapped(std::size_t bytes) { return bytes > k_pool_largest; }
#endif
  T* allocate(std::size_t n) {
    const std::size_t bytes = n * sizeof(T);
    void* p = nullptr;
    if (pooled(bytes))
      p = pool_allocate(bytes);
    else if (mapped(bytes))
      p = map_allocate(bytes);
    else
      p = std::aligned_alloc(64, bytes == 0 ? 64 : (bytes + 63) / 64 * 64);
    if (p == nullptr) throw std::bad_alloc();
    return static_cast<T*>(p);
  }
  void deallocate(T* p, std::size_t n) noexcept {
    if (pooled(n * sizeof(T)))
      pool_free(p, n * sizeof(T));
    else if (mapped(n * sizeof(T)))
      map_free(p, n * sizeof(T));
    else
      std::free(p);
  }
  // Columns are sized before they are filled in parallel: do not touch pages in resize().
  template <class U>
  void construct(U* p) noexcept {
    ::new (static_cast<void*>(p)) U;
  }
  template <class U, class... A>
  void construct(U* p, A&&... a) {
    ::new (static_cast<void*>(p)) U(static_cast<A&&>(a)...);
  }
  template <class U>
  bool operator==(const AlignedAllocator<U>&) const noexcept {
    return true;
  }
};
/// Aligned growable array; resize() leaves new trivially constructible elements uninitialised.
template <class T>
using Column = std::vector<T, AlignedAllocator<T>>;

}  // namespace talus
