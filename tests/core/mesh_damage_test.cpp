// Claims about damaged meshes: whatever the bytes, a reader returns a valid mesh or one line, soon, and with memory
// bounded by the bytes. Deterministic, so that a finding can be repeated.
#include <cmath>

#include "core/base/rng.hpp"
#include "mesh_support.hpp"

namespace talus {
namespace {

using namespace mesh_test;

/// One of the kinds of damage that transfers, editors and disks do.
std::string damaged(const std::string& good, const std::string& other, const CounterRng& rng, std::uint64_t k) {
  std::string s = good;
  std::uint64_t draw = 64 * k;
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(rng.bits(draw++) % (n == 0 ? 1 : n)); };
  static const char* const words[] = {"nan",
                                      "-1",
                                      "0",
                                      "1e999",
                                      "99999999999",
                                      "4294967295",
                                      "solid",
                                      "facet",
                                      "endloop",
                                      "vertex",
                                      "f",
                                      "v",
                                      "/",
                                      "//",
                                      "\\\n",
                                      "\r",
                                      "\n",
                                      "#",
                                      "list",
                                      "element face 7\n",
                                      "element vertex 99\n",
                                      "property int q\n",
                                      "end_header\n",
                                      "property list uchar int vertex_indices\n",
                                      "-",
                                      "1.#IND",
                                      ",",
                                      "\xff",
                                      "3 1 1 1\n",
                                      "f 1 1 1 1 2 3\n",
                                      "f -1 -2 -3\n",
                                      "9",
                                      ".",
                                      "D5"};
  const std::size_t times = 1 + below(4);
  for (std::size_t i = 0; i < times && !s.empty(); ++i) switch (below(8)) {
      case 0:
        s[below(s.size())] = static_cast<char>(below(256));
        break;
      case 1:
        s[below(s.size())] ^= static_cast<char>(1U << below(8));
        break;
      case 2:
        s.resize(below(s.size()));
        break;
      case 3:
        s.erase(below(s.size()), 1 + below(40));
        break;
      case 4:
        s.insert(below(s.size()), words[below(std::size(words))]);
        break;
      case 5: {
        const std::size_t from = below(s.size());
        s.insert(below(s.size()), s.substr(from, below(80)));
        break;
      }
      case 6: {
        const std::size_t from = below(other.size());
        s.replace(below(s.size()), below(60), other.substr(from, below(60)));
        break;
      }
      default: {  // a number of four bytes
        const std::uint32_t extreme[] = {0, 1, 0x7fffffffU, 0x80000000U, 0xffffffffU, 0x7fc00000U, 0x7f800000U, 255};
        const std::uint32_t n = extreme[below(8)];
        if (s.size() >= 4) std::memcpy(s.data() + below(s.size() - 3), &n, 4);
      }
    }
  return s;
}

void expect_valid(const Mesh& m, std::size_t bytes) {
  ASSERT_FALSE(m.facets.empty());
  ASSERT_LE(m.facets.size(), 2 * bytes);
  ASSERT_LE(m.points.size(), 3 * m.facets.size());
  for (const auto& t : m.facets)
    for (const std::int32_t v : t) {
      ASSERT_GE(v, 0);
      ASSERT_LT(static_cast<std::size_t>(v), m.points.size());
      for (int k = 0; k < 3; ++k) ASSERT_LE(std::fabs(m.points[v][k]), 1e12);
    }
  const MeshReport& r = m.report;
  ASSERT_EQ(r.facets_read, m.size() + r.dropped());
  ASSERT_TRUE(std::isfinite(r.volume));
  ASSERT_EQ(r.watertight, r.open_edges == 0 && r.forked_edges == 0);
}

TEST(MeshDamage, AnyBytesGiveAValidMeshOrOneLine) {
  std::string binary_ply =
      "ply\nformat binary_little_endian 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 12\nproperty list uchar int vertex_indices\nend_header\n";
  for (const Vec3& p : box_points())
    for (int k = 0; k < 3; ++k) put(binary_ply, static_cast<float>(p[k]));
  for (const auto& f : k_box) {
    put(binary_ply, std::uint8_t{3});
    for (const int v : f) put(binary_ply, v);
  }
  const std::string concave =
      "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nvt 0 0\nf 1/1 2/1 3 4//1 5/1/1 \\\n 6\n";
  const std::pair<const char*, std::string> good[] = {{"a.stl", text_stl()},     {"a.stl", binary_stl()},
                                                      {"a.obj", box_obj()},      {"a.obj", concave},
                                                      {"a.ply", box_ply_text()}, {"a.ply", binary_ply}};
  const CounterRng rng(1, 2);
  std::int64_t read = 0, refused = 0;
  for (std::uint64_t k = 0; k < 24000; ++k) {
    const auto& [name, bytes] = good[k % 6];
    const std::string s = damaged(bytes, good[rng.bits(64 * k + 63) % 6].second, rng, k);
    SCOPED_TRACE(k);
    try {
      const Mesh m = parse(name, s);
      ++read;
      expect_valid(m, s.size());
      EXPECT_EQ(describe(m.report).find('\n'), std::string::npos);
    } catch (const Error& e) {
      ++refused;
      const std::string message = e.what();
      ASSERT_EQ(e.code(), ErrorCode::scene);
      ASSERT_LT(message.size(), 400U);
      for (const char c : message) ASSERT_TRUE(c >= ' ' && c <= '~') << message;
    }
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(read, 1000);
  EXPECT_GT(refused, 10000);
}

}  // namespace
}  // namespace talus
