// Claims about PLY files: all encodings, types and orders of properties read alike; headers that do not fit the bytes
// are refused before anything is allocated.
#include "mesh_support.hpp"

namespace talus {
namespace {

using namespace mesh_test;

/// The box with vertices of type T, lists of (C, I), some further properties and elements around them.
template <class T, class C, class I>
std::string binary_ply(bool big, const char* t, const char* c, const char* i, bool extras = false) {
  std::string s =
      std::string("ply\nformat binary_") + (big ? "big" : "little") + "_endian 1.0\ncomment made by a test\n";
  const std::string type = t;
  if (extras) s += "element camera 2\nproperty double a\nproperty list uchar short b\n";
  s += "element vertex 8\n";
  if (extras) s += "property uchar red\n";
  s += "property " + type + (extras ? " z\n" : " x\n") + "property " + type + " y\n";
  if (extras) s += "property list uint8 float32 more\n";
  s += "property " + type + (extras ? " x\n" : " z\n") + "element face 12\n";
  if (extras) s += "property float quality\n";
  s += std::string("property list ") + c + " " + i + " vertex_ind" + (extras ? "ex" : "ices") + "\nend_header\n";
  if (extras)
    for (int k = 0; k < 2; ++k) {
      put(s, 1.5, big);
      put(s, std::uint8_t{2}, big);
      put(s, std::int16_t{7}, big);
      put(s, std::int16_t{8}, big);
    }
  for (const Vec3& p : box_points(4, 4, 1)) {
    if (extras) put(s, std::uint8_t{9}, big);
    put(s, static_cast<T>(extras ? p.z : p.x), big);
    put(s, static_cast<T>(p.y), big);
    if (extras) put(s, std::uint8_t{1}, big), put(s, 3.0F, big);
    put(s, static_cast<T>(extras ? p.x : p.z), big);
  }
  for (const auto& f : k_box) {
    if (extras) put(s, 0.5F, big);
    put(s, static_cast<C>(3), big);
    for (const int v : f) put(s, static_cast<I>(v), big);
  }
  return s;
}

TEST(PlyFile, EncodingsAndTypesReadAlike) {
  const MeshFrame quarter{0.25, {}, {}};
  const auto expect = [&](const std::string& s) { expect_box(parse("a.ply", s, quarter), s.substr(0, 200)); };
  for (const bool big : {false, true}) {
    expect(binary_ply<float, std::uint8_t, std::int32_t>(big, "float", "uchar", "int"));
    expect(binary_ply<double, std::uint8_t, std::uint32_t>(big, "double", "uint8", "uint32"));
    expect(binary_ply<double, std::int32_t, std::int8_t>(big, "float64", "int", "char"));
    expect(binary_ply<float, std::int16_t, std::uint16_t>(big, "float32", "short", "ushort"));
    expect(binary_ply<std::int32_t, std::uint32_t, std::int64_t>(big, "int", "uint", "int64"));
    expect(binary_ply<std::uint8_t, std::int8_t, std::int16_t>(big, "uchar", "int8", "int16"));
    expect(binary_ply<double, std::uint8_t, std::int32_t>(big, "double", "uchar", "int", true));
    expect(binary_ply<float, std::uint16_t, std::uint8_t>(big, "float", "uint16", "uchar", true));
  }
}

TEST(PlyFile, DialectsOfTextReadAlike) {
  const std::string plain = box_ply_text();
  const std::pair<const char*, std::string> dialects[] = {
      {"plain", plain},
      {"vertex_index", replaced(plain, "vertex_indices", "vertex_index")},
      {"CR LF", replaced(plain, "\n", "\r\n")},
      {"CR", replaced(plain, "\n", "\r")},
      {"comments", replaced(plain, "format", "comment  : a\nobj_info b\nformat")},
      {"blank lines", replaced(plain, "\n3 ", "\n\n 3\t")},
      {"no end of line", plain.substr(0, plain.size() - 1)},
      {"byte order mark", "\xef\xbb\xbf" + plain},
      {"empty elements", replaced(plain, "element face", "element edge 0\nproperty int vertex1\nelement face")},
      {"element without properties", replaced(plain, "element face", "element nothing 999999999\nelement face")},
  };
  for (const auto& [what, text] : dialects) expect_box(parse("a.ply", text), what);
  const std::string body = "end_header\n0 0 0\n";
  expect_box(parse(
      "a.ply", replaced(replaced(plain, "element face", "element camera 1\nproperty list int float a\nelement face"),
                        "3 0 2 1\n", "2 0.5 nan\n3 0 2 1\n")));
}

TEST(PlyFile, BinaryBodiesFollowTheHeadersLineEnds) {
  std::string s = binary_ply<double, std::uint8_t, std::int32_t>(false, "double", "uchar", "int");
  const std::size_t body = s.find("end_header\n") + 11;
  const MeshFrame quarter{0.25, {}, {}};
  expect_box(parse("a.ply", replaced(s.substr(0, body), "\n", "\r\n") + s.substr(body), quarter));
  // with CR alone a body may begin with the byte of LF
  s = "ply\rformat binary_little_endian 1.0\relement vertex 3\rproperty uchar x\rproperty uchar y\rproperty uchar z\r"
      "element face 1\rproperty list uchar uchar vertex_indices\rend_header\r";
  for (const int b : {10, 0, 0, 20, 0, 0, 10, 5, 0, 3, 0, 1, 2}) s += static_cast<char>(b);
  EXPECT_EQ(parse("a.ply", s).report.lower.x, 10);
}

TEST(PlyFile, TriangleStripsBecomeTriangles) {
  const std::string s =
      "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\nelement "
      "tristrips "
      "1\nproperty list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 5\n1 0 5\n0 1 5\n1 1 5\n"
      "9 0 1 2 3 -1 4 5 6 7\n";
  const Mesh m = parse("a.ply", s);
  EXPECT_EQ(m.size(), 4);
  EXPECT_EQ(m.report.parts, 2);
  EXPECT_EQ(m.report.flipped, 0);  // strips are wound alternately
  for (const auto& f : m.facets)
    EXPECT_GT(cross(m.points[f[1]] - m.points[f[0]], m.points[f[2]] - m.points[f[0]]).z, 0);
}

TEST(PlyFile, PolygonsOfAnyLengthAreCut) {
  std::string s = box_ply_text();
  s = s.substr(0, s.find("3 0 2 1"));
  s = replaced(s, "element face 12", "element face 6");
  expect_box(parse("a.ply", s + "4 0 2 3 1\n4 4 5 7 6\n4 0 1 5 4\n4 2 6 7 3\n4 0 4 6 2\n4 1 3 7 5\n"));
}

TEST(PlyFile, DamagedHeadersAreRefusedWithTheirLine) {
  const std::string plain = box_ply_text();
  const std::tuple<const char*, const char*, const char*> cases[] = {
      {"ply\n", "pli\n", "a.ply:1"},
      {"format ascii 1.0", "format ascii 2.0", "a.ply:2"},
      {"format ascii 1.0", "format utf8 1.0", "\"utf8\""},
      {"format ascii 1.0\n", "", "no format"},
      {"element vertex 8", "element vertex -8", "a.ply:3"},
      {"element vertex 8", "element vertex", "a.ply:3"},
      {"element vertex 8", "element vertex 8x", "\"8x\""},
      {"element vertex 8", "element vertex 999999999999999999", "a.ply:3"},
      {"element vertex 8", "element vertex 99999999999999999999999", "a.ply:3"},
      {"element face 12", "element face 4000000000", "a.ply:7"},
      {"element face 12", "element face 13", "the file ends after 12 of 13"},
      {"element face 12", "element face 11", "after the last element"},
      {"element face 12", "element face 0", "cloud"},
      {"element vertex 8", "element points 8", "no element vertex"},
      {"property double z", "property double w", "lack x, y or z"},
      {"property double z", "property list uchar double z", "lack x, y or z"},
      {"property double y", "property double x", "a second property"},
      {"property double z", "property quad z", "\"quad\""},
      {"property double z", "property double", "without a name"},
      {"list uchar int", "list float int", "\"float\""},
      {"list uchar int", "list uchar double", "\"double\""},
      {"vertex_indices", "corner", "no list of vertices"},
      {"element vertex 8\n", "", "before the first element"},
      {"end_header\n", "", "a.ply:9"},
      {"property list", "junk list", "\"junk\""},
  };
  for (const auto& [from, to, part] : cases) expect_in(refusal("a.ply", replaced(plain, from, to)), part);
  expect_in(refusal("a.ply", plain.substr(0, plain.find("property double z"))), "within its header");
}

TEST(PlyFile, DamagedBodiesAreRefusedWithTheirLine) {
  const std::string plain = box_ply_text();
  const std::tuple<const char*, const char*, const char*> cases[] = {
      {"\n1 1 0\n", "\n1 1\n", "a.ply:13"},     {"\n1 1 0\n", "\n1 1 0 0\n", "a.ply:13"},
      {"\n1 1 0\n", "\n1 nan 0\n", "a.ply:13"}, {"3 0 2 1\n", "3 0 2 8\n", "a.ply:18"},
      {"3 0 2 1\n", "3 0 2 -1\n", "a.ply:18"},  {"3 0 2 1\n", "3 0 2\n", "a.ply:18"},
      {"3 0 2 1\n", "2 0 2\n", "a.ply:18"},     {"3 0 2 1\n", "-1 0 2 1\n", "a.ply:18"},
      {"3 0 2 1\n", "3 0 2.5 1\n", "a.ply:18"}, {"3 0 2 1\n", "999999999 0 2 1\n", "a.ply:18"},
      {"3 0 2 1\n", "3 0 2 1 4\n", "a.ply:18"},
  };
  for (const auto& [from, to, part] : cases) expect_in(refusal("a.ply", replaced(plain, from, to)), part);
  std::string s = binary_ply<double, std::uint8_t, std::int32_t>(false, "double", "uchar", "int");
  const std::size_t body = s.find("end_header\n") + 11;
  for (std::size_t at = body; at < s.size(); at += 7) EXPECT_NE(refusal("a.ply", s.substr(0, at)), "no error");
  expect_in(refusal("a.ply", s + "x"), "1 bytes follow");
  s[body + 8 * 24] = 100;  // corners of the first face
  EXPECT_NE(refusal("a.ply", s), "no error");
}

}  // namespace
}  // namespace talus
