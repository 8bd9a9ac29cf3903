// Claims about STL files: every dialect of exporters is read alike and in double precision; what is damaged is refused
// with the place and the reason.
#include <algorithm>

#include "mesh_support.hpp"

namespace talus {
namespace {

using namespace mesh_test;

std::string upper_case(std::string s) {
  for (char& c : s) c = static_cast<char>(c >= 'a' && c <= 'z' ? c - 'a' + 'A' : c);
  return s;
}

TEST(StlFile, DialectsOfTextReadAlike) {
  const std::string plain = text_stl();
  std::string tabs = plain;
  std::replace(tabs.begin(), tabs.end(), ' ', '\t');
  std::string one_line = replaced(plain, "\n", " ");
  const std::pair<const char*, std::string> dialects[] = {
      {"plain", plain},
      {"upper case", upper_case(plain)},
      {"mixed case", replaced(replaced(plain, "vertex", "Vertex"), "endfacet", "EndFacet")},
      {"byte order mark", "\xef\xbb\xbf" + plain},
      {"comment first", "# made by me\n// twice\n\n; and more\n" + plain},
      {"comments within", replaced(plain, "    endloop", "# corner 3\n    endloop # end")},
      {"CR LF", replaced(plain, "\n", "\r\n")},
      {"CR", replaced(plain, "\n", "\r")},
      {"tabs", tabs},
      {"no lines", one_line},
      {"no endsolid", plain.substr(0, plain.find("endsolid"))},
      {"no name", replaced(plain, "solid part", "solid")},
      {"end solid",
       replaced(replaced(replaced(plain, "endsolid", "end solid"), "endloop", "end loop"), "endfacet", "end facet")},
      {"name joined", replaced(plain, "endsolid part", "endsolidpart")},
      {"long name",
       replaced(plain, "solid part", "solid facet of a part, (c) M\xfcller / 1 2 3 " + std::string(300, '/'))},
      {"no normals", replaced(plain, "facet normal 0 0 0", "facet")},
      {"normals of Windows", replaced(plain, "normal 0 0 0", "normal -1.#IND 1.#QNAN -nan(ind)")},
      {"normals of others", replaced(plain, "normal 0 0 0", "normal nan -NaN inf")},
      {"colour", replaced(plain, "solid part\n  facet", "solid part\n color 1 0 0\n  facet")},
      {"Fortran", replaced(plain, " 0.25", " 2.5D-01")},
      {"small d", replaced(plain, " 0.25", " 25.d-2")},
      {"plus and points", replaced(replaced(plain, " 0.25", " +.25"), " 1", " 1.")},
      {"exponents", replaced(replaced(plain, " 0.25", " 2.5e-001"), " 1", " +1.000000E+00")},
      {"end of file of DOS", plain + "\x1a"},
      {"NULs at the end", plain + std::string(200, '\0')},
  };
  for (const auto& [what, text] : dialects) expect_box(parse("a.stl", text), what);
}

TEST(StlFile, SeveralSolidsAreOneMesh) {
  std::string s = text_stl();
  const std::size_t middle = s.find("  facet", s.size() / 2);
  s.insert(middle, "endsolid part\n\nSolid other part\n");
  expect_box(parse("a.stl", s));
}

TEST(StlFile, BinaryIsToldBySizeWhateverItsHeader) {
  for (const char* header : {"part", "solid x", "SOLID", "solid facet normal", "\xef\xbb\xbf solid", "# x"})
    expect_box(parse("a.STL", binary_stl(12, header)), header);
  std::string attributes = binary_stl();
  for (std::size_t f = 0; f < 12; ++f) attributes[84 + 50 * f + 48] = static_cast<char>(0x7f + f);
  expect_box(parse("a.stl", attributes));
}

TEST(StlFile, PaddingAfterTheLastFacetIsSaid) {
  const Mesh m = parse("a.stl", binary_stl() + "tail\n");
  expect_box(m);
  ASSERT_EQ(m.report.notes.size(), 1U);
  expect_in(m.report.notes[0], "5 bytes");
  expect_box(parse("a.stl", binary_stl() + std::string(428, '\0')));
  EXPECT_EQ(parse("a.stl", text_stl().substr(0, text_stl().find("endsolid"))).report.notes.size(), 1U);
}

TEST(StlFile, WrongNumbersOfFacetsAreRefusedWithBothNumbers) {
  expect_in(refusal("a.stl", binary_stl(0)), "0 facets");
  expect_in(refusal("a.stl", binary_stl(0)), "12 facets more");
  expect_in(refusal("a.stl", binary_stl(11) + binary_stl().substr(84)), "11 facets");
  expect_in(refusal("a.stl", binary_stl(0xffffffffU)), "4294967295");
  const std::string cut = refusal("a.stl", binary_stl(12, "solid x").substr(0, 664));
  expect_in(cut, "684 bytes");
  expect_in(cut, "664");
  expect_in(cut, "within facet 12");
  expect_in(refusal("a.stl", binary_stl(12).substr(0, 84 + 50 * 5)), "after facet 5");
  expect_in(refusal("a.stl", binary_stl(0).substr(0, 84)), "no facets");
  expect_in(refusal("a.stl", binary_stl().substr(0, 83)), "84 bytes");
}

TEST(StlFile, TextCutAnywhereWithinAFacetIsRefusedWithItsLine) {
  const std::string s = text_stl();
  const std::size_t begin = s.find("  facet", 600), end = s.find("endfacet", begin) + 7;
  for (std::size_t at = begin + 3; at < end; ++at) expect_in(refusal("a.stl", s.substr(0, at)), "a.stl:");
  const std::size_t eighth = s.find("  facet", 980);
  const std::string m = refusal("a.stl", s.substr(0, eighth + 5));
  expect_in(m, "a.stl:" + std::to_string(std::count(s.begin(), s.begin() + static_cast<long>(eighth), '\n') + 1));
  expect_in(m, "\"fac\"");
}

TEST(StlFile, AMissingFacetLeavesThreeOpenEdgesAndIsDoubted) {
  const Mesh m = parse("a.stl", text_stl(box_points(), 11));
  EXPECT_EQ(m.size(), 11);
  EXPECT_EQ(m.report.open_edges, 3);
  EXPECT_EQ(m.report.holes, 1);
  EXPECT_FALSE(m.report.watertight);
  expect_in(doubts(m.report, 0.01), "a hole where a facet is missing; 3 open edges");
  expect_in(describe(m.report), "11 facets, not watertight");
  EXPECT_EQ(doubts(parse("a.stl", text_stl()).report, 0.01), "");
}

TEST(StlFile, WhatIsNoNumberIsRefusedWithItsLine) {
  const std::string s = text_stl();
  for (const char* bad :
       {"nan", "inf", "-1.#IND", "0,25", "0x1p-2", "1e", "--1", "1.2.3", "1e400", ".", "2.5D", "1-2"}) {
    const std::string text = replaced(s, " 0.25\n", std::string(" ") + bad + "\n");
    const std::string m = refusal("a.stl", text);
    expect_in(m, "a.stl:18");
    expect_in(m, bad);
  }
  expect_in(refusal("a.stl", replaced(s, " 0.25\n", "\n")), "a.stl:19");  // the next line's word instead of a number
  expect_in(refusal("a.stl", replaced(s, " 0.25\n", " 0.25 7\n")), "\"7\"");
  expect_in(refusal("a.stl", replaced(s, "      vertex 1 0 0.25\n", "")), "one of 3 vertices");
  expect_in(refusal("a.stl", replaced(s, "    endloop\n", "")), "endloop");
  expect_in(refusal("a.stl", replaced(s, "    endloop\n", "vertex 0 0 0\nendloop\n")), "3 vertices");
}

TEST(StlFile, TextIsReadInDoublePrecisionToTheLastBit) {
  std::vector<Vec3> p = box_points();
  for (Vec3& q : p) q = {q.x + 500123.123456789, q.y + 5200456.1, q.z + 1e-17};
  const Mesh m = parse("a.stl", text_stl(p));
  for (std::size_t f = 0; f < k_box.size(); ++f)
    for (int c = 0; c < 3; ++c)
      for (int k = 0; k < 3; ++k) EXPECT_EQ(m.points[m.facets[f][c]][k], p[k_box[f][c]][k]);
}

TEST(StlFile, OtherContentIsNamed) {
  expect_in(refusal("a.stl", std::string("\x1f\x8b\x08\x00more", 8)), "compressed");
  std::string wide = "\xff\xfe";
  for (const char c : text_stl()) wide += c, wide += '\0';
  expect_in(refusal("a.stl", wide), "UTF-16");
  expect_in(refusal("a.stl", wide.substr(2)), "UTF-16");
  expect_in(refusal("a.stl", "<!DOCTYPE html>\n<html>"), "DOCTYPE");
  expect_in(refusal("a.stl", "solid\nendsolid\n"), "no facets");
  expect_in(refusal("a.stl", ""), "empty");
}

}  // namespace
}  // namespace talus
