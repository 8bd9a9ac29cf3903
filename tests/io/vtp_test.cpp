// VTK XML files, read back by VTK itself (check_vtp.py).
#include "core/io/vtp.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "core/base/error.hpp"
#include "core/frame/quantities.hpp"
#include "tests/io/output_frames.hpp"

namespace talus {
namespace {

using test::make_frame;
using test::python;
using test::TemporaryFolder;

const ParticleColumns k_all = ParticleColumns::all();

TEST(Vtp, VtkReadsParticlesWallsAndContacts) {
  TemporaryFolder folder;
  const Frame f = make_frame(8, 57, 6);
  write_vtp(folder / "p.vtp", particle_poly(f, k_all), f.time);
  write_vtp(folder / "w.vtp", wall_poly(f), f.time);
  write_vtp(folder / "c.vtp", contact_poly(f), f.time);
  EXPECT_TRUE(python("check_vtp.py", "particles " + folder / "p.vtp" + " 8 57"));
  EXPECT_TRUE(python("check_vtp.py", "walls " + folder / "w.vtp" + " 8 6"));
  EXPECT_TRUE(python("check_vtp.py", "contacts " + folder / "c.vtp" + " 8 57"));
  EXPECT_FALSE(python("check_vtp.py", "particles " + folder / "p.vtp" + " 9 57 2>/dev/null"));  // it can fail
}

TEST(Vtp, FrameWithoutParticlesIsValid) {
  TemporaryFolder folder;
  write_vtp(folder / "p.vtp", particle_poly(make_frame(4, 0), k_all), 0.5);
  EXPECT_TRUE(python("check_vtp.py", "particles " + folder / "p.vtp" + " 4 0"));
}

TEST(Vtp, GridIsReadWithItsGeometry) {
  TemporaryFolder folder;
  GridData g;
  g.lower = {-1, 0, 0.5};
  g.spacing = {0.5, 0.25, 2};
  g.cells = {4, 3, 2};
  std::vector<double> values;
  for (int k = 0; k < 24; ++k) values.push_back(k);
  g.cell_data.push_back({"value", 1, values});
  write_vti(folder / "g.vti", g, 0);
  EXPECT_TRUE(python("check_vtp.py", "grid " + folder / "g.vti" + " 4 3 2"));
}

void add(PvdCollection& c, int step, int n) {
  const Frame f = make_frame(step, n);
  write_vtp(c.path(step), particle_poly(f, k_all), f.time);
  c.add(step, f.time);
}

TEST(Pvd, ListsFramesAndFollowsAResume) {
  TemporaryFolder folder;
  {
    PvdCollection c(folder.path(), "particles");
    for (int step : {0, 7, 14, 21}) add(c, step, step + 1);
    write_vtp(c.path(28), particle_poly(make_frame(28, 1), k_all), 3.5);  // killed before it was listed
  }
  const std::string list = folder / "particles.pvd";
  EXPECT_TRUE(python("check_vtp.py", "pvd " + list + " 0:1 7:8 14:15 21:22"));
  const std::string whole = test::slurp(list);
  {
    auto c = PvdCollection::resume(folder.path(), "particles", 8);
    EXPECT_EQ(c.last_step(), 7);
    EXPECT_FALSE(std::filesystem::exists(c.path(14)));
    EXPECT_FALSE(std::filesystem::exists(c.path(28)));
    EXPECT_TRUE(python("check_vtp.py", "pvd " + list + " 0:1 7:8"));
    for (int step : {14, 21}) add(c, step, step + 1);
    EXPECT_THROW(c.add(21, 1), Error);
  }
  EXPECT_EQ(test::slurp(list), whole);
  EXPECT_EQ(PvdCollection::resume(folder.path(), "other", 8).last_step(), -1);
  EXPECT_EQ(PvdCollection::resume(folder.path(), "particles", 99).size(), 4u);
}

TEST(Pvd, DamagedListIsAnError) {
  TemporaryFolder folder;
  {
    PvdCollection c(folder.path(), "particles");
    add(c, 1, 1);
  }
  std::string text = test::slurp(folder / "particles.pvd");
  text.replace(text.find("particles-0"), 11, "particles-x");
  test::spill(folder / "particles.pvd", text);
  EXPECT_THROW(PvdCollection::resume(folder.path(), "particles", 8), Error);
}

}  // namespace
}  // namespace talus
