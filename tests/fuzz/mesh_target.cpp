// Meshes in all formats.
#include <string_view>

#include "core/error.hpp"
#include "core/io/mesh_file.hpp"
#include "tests/fuzz/targets.hpp"

namespace talus::fuzz {

void mesh(Bytes input) {
  if (input.empty()) return;
  static constexpr const char* k_names[] = {"fuzz.stl", "fuzz.obj", "fuzz.ply"};
  const Bytes rest = input.subspan(1);
  try {
    const Mesh m = parse_mesh({reinterpret_cast<const char*>(rest.data()), rest.size()}, k_names[input[0] % 3], {}, 0);
    for (const auto& t : m.facets)
      for (const auto v : t)
        if (v < 0 || static_cast<std::size_t>(v) >= m.points.size()) __builtin_trap();
    for (const Vec3& x : m.points)
      for (int a = 0; a < 3; ++a)
        if (!(x[a] - x[a] == 0)) __builtin_trap();
  } catch (const Error&) {
  }
}

}  // namespace talus::fuzz
