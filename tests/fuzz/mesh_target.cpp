// Meshes in all formats.
#include <string_view>

#include "core/base/error.hpp"
#include "core/meshes/mesh_file.hpp"
#include "tests/fuzz/targets.hpp"

namespace talus::fuzz {

void mesh(Bytes input) {
  if (input.empty()) return;
  static constexpr const char* k_names[] = {"fuzz.stl", "fuzz.obj", "fuzz.ply"};
  const Bytes rest = input.subspan(1);
  try {
    const Mesh m = parse_mesh({reinterpret_cast<const char*>(rest.data()), rest.size()}, k_names[input[0] % 3], {}, 0);
    claim(!m.facets.empty(), "a mesh without facets");
    claim(m.report.facets_read == m.size() + m.report.dropped(), "facets are neither kept nor dropped");
    for (const auto& t : m.facets) {
      for (const auto v : t)
        claim(v >= 0 && static_cast<std::size_t>(v) < m.points.size(), "a facet of a vertex that is not there");
      claim(t[0] != t[1] && t[1] != t[2] && t[2] != t[0], "a degenerate facet");
    }
    for (const Vec3& x : m.points) claim(norm2(0.0 * x) == 0, "a vertex is not finite");
    describe(m.report);
    doubts(m.report, 1e-3);
  } catch (const Error& e) {
    check_message(e);
  }
}

}  // namespace talus::fuzz
