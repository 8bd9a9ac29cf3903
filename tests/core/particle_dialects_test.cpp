// Claims about particle files as other programs write them: what is harmless is read and said once, what would be read
// wrongly is refused in one line.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/base/error.hpp"
#include "core/tables/particle_columns.hpp"
#include "core/tables/particle_file.hpp"

namespace talus {
namespace {

const std::vector<Material> k_one = {{"glass", 2500, 0, 0}};
const std::vector<Material> k_two = {{"glass", 2500, 0, 0}, {"steel", 7800, 0, 0}};

ParticleFile read(std::string_view text, const std::vector<Material>& materials = k_one) {
  return parse_particles(text, "p", materials);
}

std::string refusal(std::string_view text, const std::vector<Material>& materials = k_one) {
  try {
    read(text, materials);
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::scene);
    const std::string message = e.what();
    EXPECT_LE(message.size(), 985u);
    for (const char c : message) EXPECT_FALSE(static_cast<unsigned char>(c) < 0x20 || c == 0x7f) << message;
    return message;
  }
  return "accepted";
}

#define EXPECT_CONTAINS(text, part) EXPECT_NE(std::string(text).find(part), std::string::npos) << text

/// One particle at (0.02, 0.05, 0.06) of radius 0.005 and velocity (1, 2, 3).
void expect_the_one(const ParticleFile& p) {
  ASSERT_EQ(p.size(), 1u);
  EXPECT_EQ(p.x[0].x, 0.02);
  EXPECT_EQ(p.x[0].y, 0.05);
  EXPECT_EQ(p.x[0].z, 0.06);
  EXPECT_EQ(p.r[0], 0.005);
  EXPECT_EQ(p.v[0].x, 1);
  EXPECT_EQ(p.v[0].y, 2);
  EXPECT_EQ(p.v[0].z, 3);
}

struct Dialect {
  const char *name, *text, *note;  ///< note: part of the only one; "" where there is nothing to say
};

const Dialect k_tables[] = {
    {"Plain", "x,y,z,radius,vx,vy,vz\n0.02,0.05,0.06,0.005,1,2,3\n", ""},
    {"Diameter", "x,y,z,diameter,vx,vy,vz\n0.02,0.05,0.06,0.01,1,2,3\n", ""},
    {"RadiusAndDiameter", "x,y,z,d,r,vx,vy,vz\n0.02,0.05,0.06,0.01,0.005,1,2,3\n", ""},
    {"Semicolon", "x;y;z;radius;vx;vy;vz\n0.02;0.05;0.06;0.005;1;2;3\n", ""},
    {"DecimalComma", "x;y;z;radius;vx;vy;vz\n0,02;0,05;0,06;5,0e-3;1;2;3\n",
     "decimal commas are read as decimal points"},
    {"TabsAndDecimalComma", "x\ty\tz\tr\tvx\tvy\tvz\n0,02\t0,05\t0,06\t0,005\t1\t2\t3\n", "decimal commas"},
    {"Tab", "x\ty\tz\tradius\tvx\tvy\tvz\n0.02\t0.05\t0.06\t0.005\t1\t2\t3\n", ""},
    {"Blanks", "x  y z radius vx vy vz\n 0.02  0.05 0.06 0.005   1 2 3 \n", ""},
    {"Bars", "x|y|z|radius|vx|vy|vz\n0.02|0.05|0.06|0.005|1|2|3\n", ""},
    {"PaddedCommas", "x,\ty,\tz,\tradius,\tvx,\tvy,\tvz\n0.02,\t0.05,\t0.06,\t0.005,\t1,\t2,\t3\n", ""},
    {"UpperCase", "X,Y,Z,Radius,VX,VY,VZ\n0.02,0.05,0.06,0.005,1,2,3\n", ""},
    {"Quoted",
     "\"x\",\"y\",\"z\",\"radius\",\"vx\",\"vy\",\"vz\"\n\"0.02\",\"0.05\",\"0.06\",\"0.005\",\"1\",\"2\",\"3\"\n", ""},
    {"QuotedBlanks", "\"x\" \"y\" \"z\" \"radius\" \"vx\" \"vy\" \"vz\"\n0.02 0.05 0.06 0.005 1 2 3\n", ""},
    {"SingleQuotes", "'x','y','z','radius','vx','vy','vz'\n0.02,0.05,0.06,0.005,1,2,3\n", ""},
    {"ParaView",
     "\"radius\",\"velocity:0\",\"velocity:1\",\"velocity:2\",\"Points:0\",\"Points:1\",\"Points:2\"\n0.005,1,2,3,0.02,"
     "0.05,0.06\n",
     ""},
    {"ParaViewMagnitude",
     "\"Point ID\",\"Points_0\",\"Points_1\",\"Points_2\",\"Points_Magnitude\",\"radius\",\"vx\",\"vy\",\"vz\"\n"
     "0,0.02,0.05,0.06,0.08,0.005,1,2,3\n",
     "ignored: columns 'Point ID', 'Points_Magnitude'"},
    {"Coordinates", "coords:0,coords:1,coords:2,Radius,v:0,v:1,v:2\n0.02,0.05,0.06,0.005,1,2,3\n", ""},
    {"OwnNamesGoFirst", "Points:0,Points:1,Points:2,x,y,z,r,vx,vy,vz\n7,8,9,0.02,0.05,0.06,0.005,1,2,3\n",
     "ignored: columns 'Points:0', 'Points:1', 'Points:2'"},
    {"Id", "id,x,y,z,radius,vx,vy,vz\n1,0.02,0.05,0.06,0.005,1,2,3\n", "ignored: column 'id'"},
    {"IdTypeMass", "id,type,x,y,z,radius,mass,vx,vy,vz\n1,1,0.02,0.05,0.06,0.005,nan,1,2,3\n",
     "ignored: columns 'id', 'type', 'mass'"},
    {"TextsInIgnoredColumns", "x,y,z,r,vx,vy,vz,comment\n0.02,0.05,0.06,0.005,1,2,3,\"a, b\"\n",
     "ignored: column 'comment'"},
    {"Edem",
     "Extracted Data\nVersion: 2023\nTIME: ,0\n\nQ01 : Position X (m),Q02 : Position Y (m),Q03 : Position Z (m),Q04 : "
     "Particle Diameter (m),Q05 : Velocity X (m/s),Q06 : Velocity Y (m/s),Q07 : Velocity Z (m/s)\n"
     "0.02,0.05,0.06,0.01,1,2,3\n",
     "what stands before the header row 5 is ignored"},
    {"Rocky",
     "Particle X-Coordinate [m];Particle Y-Coordinate [m];Particle Z-Coordinate [m];Particle Radius [m];Translational "
     "Velocity : X [m/s];Translational Velocity : Y [m/s];Translational Velocity : Z "
     "[m/s]\n0.02;0.05;0.06;0.005;1;2;3\n",
     ""},
    {"YadeFormat", "#format x_y_z_r_vx_vy_vz\n0.02\t0.05\t0.06\t0.005\t1\t2\t3\n", "named by the comment in line 1"},
    {"NumpyComment", "# x y z radius vx vy vz\n0.02 0.05 0.06 0.005 1 2 3\n", "named by the comment in line 1"},
    {"Comments", "% made by hand\n// twice\nx,y,z,r,vx,vy,vz\n# here\n0.02,0.05,0.06,0.005,1,2,3\n", ""},
    {"ByteOrderMark", "\xef\xbb\xbfx,y,z,r,vx,vy,vz\r\n0.02,0.05,0.06,0.005,1,2,3\r\n", ""},
    {"OldMacLineEnds", "x,y,z,r,vx,vy,vz\r0.02,0.05,0.06,0.005,1,2,3\r", ""},
    {"SpreadsheetHint", "sep=;\nx;y;z;r;vx;vy;vz\n0.02;0.05;0.06;0.005;1;2;3\n", ""},
    {"TrailingSeparators", "x,y,z,r,vx,vy,vz,\n0.02,0.05,0.06,0.005,1,2,3,\n", ""},
    {"TrailingInRowsOnly", "x,y,z,r,vx,vy,vz\n0.02,0.05,0.06,0.005,1,2,3,\n", ""},
    {"TrailingInHeaderOnly", "x\ty\tz\tr\tvx\tvy\tvz\t\n0.02\t0.05\t0.06\t0.005\t1\t2\t3\n", ""},
    {"EmptyRows", "x;y;z;r;vx;vy;vz\n0.02;0.05;0.06;0.005;1;2;3\n;;;;;;\n;;\n\n", ""},
    {"Millimetres", "x (mm),y (mm),z (mm),r (mm),vx (mm/s),vy (mm/s),vz (mm/s)\n0.02,0.05,0.06,0.005,1,2,3\n",
     "lengths are in 'mm' and are not converted"},
    {"Density", "x,y,z,r,density,vx,vy,vz\n0.02,0.05,0.06,0.005,2500,1,2,3\n", ""},
    {"Umlaut",
     "x,y,z,r,vx,vy,vz,Gr\xc3\xb6\xc3\x9f"
     "e\n0.02,0.05,0.06,0.005,1,2,3,9\n",
     "ignored: column 'Gr\xc3\xb6\xc3\x9f"
     "e'"},
};

class Tables : public ::testing::TestWithParam<Dialect> {};
void PrintTo(const Dialect& d, std::ostream* out) { *out << d.name; }

TEST_P(Tables, AreReadAndWhatIsIgnoredIsSaidOnce) {
  const ParticleFile p = read(GetParam().text);
  expect_the_one(p);
  const std::string note = GetParam().note;
  ASSERT_EQ(p.notes.size(), note.empty() ? 0u : 1u) << (p.notes.empty() ? "" : p.notes[0]);
  if (!note.empty()) {
    EXPECT_CONTAINS(p.notes[0], note);
  }
}

INSTANTIATE_TEST_SUITE_P(ParticleDialects, Tables, ::testing::ValuesIn(k_tables),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(ParticleDialects, MissingVelocitiesAreZero) {
  const ParticleFile p = read("x,y,z,r\n1,2,3,4\n5,6,7,8\n");
  ASSERT_EQ(p.size(), 2u);
  EXPECT_EQ(p.v[1].x, 0);
  EXPECT_EQ(p.w[1].z, 0);
  EXPECT_TRUE(p.notes.empty());
  EXPECT_EQ(p.row[1], 3);
}

TEST(ParticleDialects, NamesMeanOneThingOrNothing) {
  using C = ParticleColumn;
  const std::pair<const char*, C> names[] = {{"Position X", C::x},
                                             {"pos_y", C::y},
                                             {"posz", C::z},
                                             {"center_x", C::x},
                                             {"Coordinates:2", C::z},
                                             {"X-Coordinate", C::x},
                                             {"Points:1", C::y},
                                             {"Vel_Z", C::vz},
                                             {"velocityx", C::vx},
                                             {"particle vx", C::vx},
                                             {"v_1", C::vy},
                                             {"omega:0", C::wx},
                                             {"omegaz", C::wz},
                                             {"Angular Velocity Y", C::wy},
                                             {"ang_vel_x", C::wx},
                                             {"Rotational Velocity : Z", C::wz},
                                             {"Particle Radius", C::radius},
                                             {"Diam.", C::diameter},
                                             {"Particle Type", C::type},
                                             {"Material", C::material},
                                             {"0", C::none},
                                             {"1", C::none},
                                             {"", C::none},
                                             {"x0", C::none},
                                             {"initial position x", C::none},
                                             {"force:0", C::none},
                                             {"displacement_x", C::none},
                                             {"Velocity:Magnitude", C::none},
                                             {"angular x", C::none},
                                             {"linear x", C::none},
                                             {"x y", C::none},
                                             {"size", C::none},
                                             {"mass", C::none},
                                             {"position", C::none},
                                             {"acceleration_x", C::none},
                                             {"contact radius", C::none},
                                             {"radius_of_gyration", C::none},
                                             {"Gr\xc3\xb6\xc3\x9f"
                                              "e x",
                                              C::none}};
  for (const auto& [name, column] : names) EXPECT_EQ(column_meaning(name).column, column) << name;
}

TEST(ParticleDialects, WhatCouldBeReadWronglyIsRefused) {
  EXPECT_CONTAINS(refusal("x;y;z;r\n0,02;0,05;0.06;0,005\n"),
                  "p:2: decimal commas (line 2) and decimal points (line 2) in one file");
  EXPECT_CONTAINS(refusal("x;y;z;r\n1.234,5;1;1;1\n"), "p:2: x: '1.234,5' is not a number");
  EXPECT_CONTAINS(refusal("x;y;z;r\n1,234,5;1;1;1\n"), "p:2: x: '1,234,5' is not a number");
  EXPECT_CONTAINS(refusal("x,y,z,r\n0,02,0,05,0,06,0,005\n"), "p:2: 8 values, but the header names 4 columns");
  EXPECT_CONTAINS(refusal("x,y,z,r,d\n1,1,1,1,1\n"), "p:2: diameter 1 is not twice the radius 1");
  EXPECT_CONTAINS(refusal("x,y,z,r,vx,vy\n1,1,1,1,1,1\n"), "p:1: vx, vy and vz come together or not at all");
  EXPECT_CONTAINS(refusal("x,y,z,r,x\n1,1,1,1,1\n"), "p:1: column 'x' is named twice");
  EXPECT_CONTAINS(refusal("pos_x,position x,y,z,r\n1,1,1,1,1\n"), "p:1: column 'position x' is named twice");
  EXPECT_CONTAINS(refusal("x (m),y (m),z (m),r (mm)\n1,1,1,1\n"), "p:1: column 'r (mm)' is in 'mm'");
  EXPECT_CONTAINS(refusal("x (m),y (m),z (m),r (m),vx (mm/s),vy (mm/s),vz (mm/s)\n1,1,1,1,1,1,1\n"), "is in 'mm/s'");
  EXPECT_CONTAINS(refusal("x,y,z,r,wx (deg/s),wy (deg/s),wz (deg/s)\n1,1,1,1,1,1,1\n"), "is in 'deg/s'");
  EXPECT_CONTAINS(refusal("x,y,z,r,density\n1,1,1,1,7800\n"),
                  "p:2: density 7800 differs from 2500 of material 'glass'");
  EXPECT_CONTAINS(refusal("x,y,z,r,type\n1,1,1,1,1\n2,2,2,1,2\n", k_two), "p:3: column 'type' has several values");
  EXPECT_EQ(read("x,y,z,r,type\n1,1,1,1,1\n2,2,2,1,2\n").size(), 2u) << "one material: a type says nothing";
  EXPECT_EQ(read("x,y,z,r,type,material\n1,1,1,1,1,steel\n2,2,2,1,2,0\n", k_two).material[0], 1);
  EXPECT_CONTAINS(refusal("x,y,z,r,fixed\n1,1,1,1,0.5\n"), "fixed: 0.5 is not allowed");
}

TEST(ParticleDialects, BrokenTablesNameTheRow) {
  EXPECT_CONTAINS(refusal(""), "no particles");
  EXPECT_CONTAINS(refusal("\n\n \n"), "no particles");
  EXPECT_CONTAINS(refusal("x,y,z,r\n"), "no particles");
  EXPECT_CONTAINS(refusal("# nothing\n"), "no particles");
  EXPECT_CONTAINS(refusal("1,2,3,4\n5,6,7,8\n"), "p:1: a row of numbers, but no header row before it");
  EXPECT_CONTAINS(refusal("2 0 0 0 0 1 1 1\n0.1 0.1 0.1 0 0 0 0.05 0 0 0 0 0 0 0\n"), "no header row") << "MercuryDPM";
  EXPECT_CONTAINS(refusal("# a b c d\n1 2 3 4\n"), "no header row");
  EXPECT_CONTAINS(refusal("x,y,z,r\n1,2,3,4\n1,2,3\n"), "p:3: 3 values, but the header names 4 columns");
  EXPECT_CONTAINS(refusal("x,y,z,r\n1,2,3,4,5\n"), "p:2: 5 values");
  EXPECT_CONTAINS(refusal("x,y,z,r\n1,2,\"3,4\n"), "p:2: a quote is not closed");
  EXPECT_CONTAINS(refusal("x,y,z,r\n1,2,3,1e999\n"), "p:2: r: '1e999' is beyond the range of numbers");
  EXPECT_CONTAINS(refusal("x,y,z,r\n1,2,3,1.0D-3\n"), "p:2: r: '1.0D-3' is not a number");
  EXPECT_CONTAINS(refusal("x,y,z,r\nm,m,m,m\n1,2,3,4\n"), "p:2: x: 'm' is not a number");
  EXPECT_CONTAINS(refusal("x,y,z,r\n1,2,3,\x1b[31m\xff\n"), "p:2: r: '\\x1b[31m\\xff' is not a number");
  EXPECT_CONTAINS(refusal("x,y,z,r\n1,2,3," + std::string(1 << 20, '1') + "e\n"), "p:2: r: '111");
  EXPECT_CONTAINS(refusal("any text\nof several\nlines\n"), "p:1: column 'x' is missing");
}

TEST(ParticleDialects, ThousandsOfColumnsAreReadAndSaidShortly) {
  std::string head = "x,y,z,r", row = "1,2,3,4";
  for (int k = 0; k < 5000; ++k) head += fmt::format(",property {}", k), row += ",0";
  const ParticleFile p = read(head + "\n" + row + "\n");
  ASSERT_EQ(p.size(), 1u);
  ASSERT_EQ(p.notes.size(), 1u);
  EXPECT_CONTAINS(p.notes[0], "'property 7' and 4992 more");
  EXPECT_LE(p.notes[0].size(), 400u);
  EXPECT_CONTAINS(refusal(head.substr(2) + "\n" + row + "\n"), "column 'x' is missing");
}

TEST(ParticleDialects, FilesOfOtherKindsAreNamedInOneLine) {
  const std::string table = "x,y,z,r\n1,2,3,4\n";
  std::string utf16 = "\xff\xfe", bare;
  for (const char c : table) (utf16 += c) += '\0', (bare += '\0') += c;
  EXPECT_CONTAINS(refusal(utf16), "p: the file is UTF-16 (save it as UTF-8 or plain ASCII)");
  EXPECT_CONTAINS(refusal("\xfe\xff" + bare), "p: the file is UTF-16");
  EXPECT_CONTAINS(refusal(bare), "p: the file is UTF-16") << "without a mark";
  EXPECT_CONTAINS(refusal("ITEM: TIMESTEP\n0\n"), "p: the file is a LAMMPS dump");
  EXPECT_CONTAINS(refusal("<?xml version=\"1.0\"?>\n"), "p: the file is XML");
  EXPECT_CONTAINS(refusal("# vtk DataFile Version 2.0\n"), "VTK");
  EXPECT_CONTAINS(refusal(std::string_view("ab\0\0cd", 6)), "p: the file is binary");
  EXPECT_CONTAINS(refusal("PK\x03\x04"
                          "abc"),
                  "workbook");
}

// ------------------------------------------------------------------------------------------------------------ LAMMPS

std::string lammps(const std::string& header, const std::string& before = "", const std::string& after = "",
                   const std::string& style = " # sphere") {
  return "trial\n\n1 atoms\n1 atom types\n" + header + "\n0 0.1 xlo xhi\n0 0.1 ylo yhi\n0 0.1 zlo zhi\n\n" + before +
         "\nAtoms" + style + "\n\n7 1 0.01 2500 0.02 0.05 0.06\n" + after;
}

TEST(LammpsDialects, HarmlessHeadersAndSectionsAreReadAndSaidOnce) {
  const std::string velocities = "\nVelocities\n\n7 1 2 3 0 0 0\n";
  const std::string zeros =
      "0 bonds\n0 angles\n0 dihedrals\n0 impropers\n0 bond types\n0 ellipsoids\n0 lines\n"
      "0 triangles\n0 bodies\n0 crossterms\n2 extra bond per atom\n";
  struct Case {
    std::string text, note;
  };
  const Case cases[] = {
      {lammps("", "", velocities), ""},
      {lammps("0.0 0.0 -0.0 xy xz yz", "", velocities), ""},
      {lammps(zeros, "", velocities), ""},
      {lammps("", "Masses\n\n1 1.0\n", velocities), "ignored: Masses"},
      {lammps("", "Pair Coeffs # granular\n\n1 hooke 1e4 50\n", velocities), "ignored: Pair Coeffs"},
      {lammps("", "PairIJ Coeffs\n\n1 1 hooke\n\nAtom Type Labels\n\n1 glass\n", velocities),
       "ignored: PairIJ Coeffs, Atom Type Labels"},
      {lammps("2 bonds\n1 bond types", "", velocities + "\nBonds\n\n1 1 7 7\n2 1 7 7\n"), "ignored: bonds, Bonds"},
      {lammps("", "", "\nBonds\n\n" + velocities + "\nEllipsoids\n\n"), ""},
      {lammps("", "", velocities, ""), ""},
      {lammps("", "", velocities, "  #granular"), ""},
  };
  for (const auto& [text, note] : cases) {
    SCOPED_TRACE(text);
    const ParticleFile p = read(text);
    expect_the_one(p);
    ASSERT_TRUE(p.box.has_value());
    ASSERT_EQ(p.notes.size(), note.empty() ? 0u : 1u);
    if (!note.empty()) {
      EXPECT_EQ(p.notes[0], "p: " + note);
    }
    std::string windows;
    for (const char c : text) windows += c == '\n' ? "\r\n" : std::string(1, c);
    expect_the_one(read(windows));
  }
}

TEST(LammpsDialects, OtherShapesStylesAndSkewedBoxesAreRefused) {
  EXPECT_CONTAINS(refusal(lammps("0.01 0 0 xy xz yz")), "the box is skewed ('0.01 0 0 xy xz yz')");
  EXPECT_CONTAINS(refusal(lammps("1 ellipsoids")), "1 ellipsoids: the particles are no spheres");
  EXPECT_CONTAINS(refusal(lammps("", "", "\nBodies\n\n7 1 3\n")), "section 'Bodies' describes other shapes");
  for (const char* style : {" # atomic", " # hybrid sphere", " # bpm/sphere", " # superquadric"})
    EXPECT_CONTAINS(refusal(lammps("", "", "", style)), "atom_style '");
  EXPECT_CONTAINS(refusal(lammps("", "", "\nAtoms\n\n8 1 0.01 2500 0.02 0.05 0.06\n")), "a second section Atoms");
  EXPECT_CONTAINS(refusal(lammps("3 crossterms")), "header line '3 crossterms' is not supported");
  EXPECT_CONTAINS(refusal(lammps("1 0 0 avec")), "header line '1 0 0 avec' is not supported");
  EXPECT_CONTAINS(refusal("t\n\n0 atoms\n1 atom types\n"), "no particles");
  EXPECT_CONTAINS(refusal(lammps("", "", "8 1 0.01 2500 0.02 0.05 0.06\n")), "2 particles, but the header says 1");
}

TEST(LammpsDialects, ParticlesWithoutAVelocityAreSaid) {
  const ParticleFile p = read(
      "t\n\n2 atoms\n0 1 xlo xhi\n\nAtoms\n\n1 1 0.1 2500 0 0 0\n2 1 0.1 2500 0.5 0 0\n\nVelocities\n\n"
      "2 1 0 0 0 0 0\n");
  ASSERT_EQ(p.notes.size(), 1u);
  EXPECT_EQ(p.notes[0], "p: 1 of 2 particles have no row in Velocities and start at rest");
  EXPECT_FALSE(p.box.has_value()) << "two of its sides are not stated";
}

TEST(LammpsDialects, ABoxThatIsNotTheDomainIsSaid) {
  const ParticleFile p = read(lammps(""));
  EXPECT_EQ(box_note(p, "p", {0, 0, 0}, {0.1, 0.1, 0.1}), "");
  EXPECT_EQ(box_note(p, "p", {0, 0, 1e-9}, {0.1, 0.1, 0.1 + 1e-9}), "") << "files are written with fewer digits";
  EXPECT_EQ(box_note(p, "p", {0, 0, 0}, {0.2, 0.1, 0.1}),
            "p: its box (0 to 0.1, 0 to 0.1, 0 to 0.1) is not the domain (0 to 0.2, 0 to 0.1, 0 to 0.1), which counts; "
            "positions are taken as they are");
  EXPECT_NE(box_note(p, "p", {-0.05, 0, 0}, {0.1, 0.1, 0.1}), "");
}

// Broken files of every kind end in an Error of one line, never in another exception, an abort or a hang.
TEST(ParticleDialects, MutatedFilesOnlyRaiseErrorsOfOneLine) {
  std::vector<std::string> seeds;
  for (const Dialect& d : k_tables) seeds.emplace_back(d.text);
  seeds.push_back(lammps("0 0 0 xy xz yz\n0 bonds", "Masses\n\n1 1.0\n", "\nVelocities\n\n7 1 2 3 0 0 0\n"));
  std::uint64_t state = 99;
  const auto random = [&](std::size_t n) {
    state = state * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<std::size_t>(state >> 33) % n;
  };
  const std::string pieces[] = {
      "\"", "\"\"", ";",    ",", "\t",    "\n",        "\r",  "#",    "(", ")", "1e999", "9007199254740993",
      "-",  "nan",  "\xc3", "x", "Atoms", "2 atoms\n", "0,5", "\x01", "_"};
  int refused = 0, read_well = 0;
  for (int i = 0; i < 20000; ++i) {
    std::string text = seeds[random(seeds.size())];
    for (std::size_t k = 0, n = 1 + random(4); k < n && !text.empty(); ++k) {
      const std::size_t at = random(text.size());
      switch (random(4)) {
        case 0:
          text.erase(at, 1 + random(6));
          break;
        case 1:
          text.insert(at, pieces[random(std::size(pieces))]);
          break;
        case 2:
          text.insert(at, text.substr(random(text.size()), random(30)));
          break;
        default:
          text[at] = static_cast<char>(random(256));
      }
    }
    if (refusal(text, i % 2 == 0 ? k_one : k_two) != "accepted") {
      ++refused;
      continue;
    }
    ++read_well;
    for (const double r : read(text, i % 2 == 0 ? k_one : k_two).r) EXPECT_GT(r, 0);
  }
  EXPECT_GT(refused, 4000);
  EXPECT_GT(read_well, 500);
}

}  // namespace
}  // namespace talus
