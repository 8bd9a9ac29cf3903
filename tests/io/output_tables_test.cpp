// The tables of what a run writes against what it does write: nothing undocumented, nothing documented that is not
// there.
#include "core/io/output_tables.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "core/frame/quantities.hpp"
#include "core/io/series.hpp"
#include "tests/io/output_frames.hpp"

namespace talus {
namespace {

TEST(OutputTables, PatternsFitWhatTheyMean) {
  EXPECT_TRUE(fits("checkpoint-<N>.tcp", "checkpoint-120.tcp"));
  EXPECT_FALSE(fits("checkpoint-<N>.tcp", "checkpoint-.tcp"));
  EXPECT_FALSE(fits("checkpoint-<N>.tcp", "checkpoint-12a.tcp"));
  EXPECT_TRUE(fits("wall.<wall>.force_{x,y,z}", "wall.a.b.force_y"));
  EXPECT_FALSE(fits("wall.<wall>.force_{x,y,z}", "wall.a.force_w"));
  EXPECT_FALSE(fits("time", "times"));
  EXPECT_FALSE(fits("times", "time"));
}

/// How many rows of a table name it.
template <class Rows>
std::ptrdiff_t rows_for(const Rows& rows, const std::string& name) {
  return std::count_if(rows.begin(), rows.end(), [&](const auto& row) { return fits(row.name, name); });
}

TEST(OutputTables, EveryColumnOfTheSeriesHasOneRowAndEveryRowAColumn) {
  SeriesLayout layout;
  layout.inserted = layout.wall_contacts = layout.energies = layout.rotation = true;
  layout.friction = layout.superquadrics = layout.sizes = true;
  Scene scene;
  scene.output.stress = scene.output.coordination = true;
  layout.averages = averages_of(scene);
  layout.walls = {"floor", "lower x"};
  layout.planes = {"out"};
  layout.regions = {"core"};
  std::set<std::string_view> used;
  for (const std::string& name : layout.columns()) {
    EXPECT_EQ(rows_for(series_columns(), name), 1) << name;
    for (const OutputColumn& row : series_columns())
      if (fits(row.name, name)) used.insert(row.name);
  }
  EXPECT_EQ(used.size(), series_columns().size());
  for (const OutputColumn& row : series_columns()) {
    EXPECT_TRUE(row.kind == "sum" || row.kind == "mean" || row.kind == "moment") << row.name;
    EXPECT_FALSE(row.unit.empty() || row.doc.empty()) << row.name;
  }
}

TEST(OutputTables, EveryColumnOfFramesHasOneRowAndEveryRowAColumn) {
  const Frame frame = test::make_frame(3, 5);
  const PolyData particles = particle_poly(frame, ParticleColumns::all()), contacts = contact_poly(frame);
  EXPECT_EQ(particles.point_data.size(), frame_columns().size());
  for (const PolyColumn& c : particles.point_data) EXPECT_EQ(rows_for(frame_columns(), c.name), 1) << c.name;
  EXPECT_EQ(contacts.point_data.size(), contact_columns().size());
  for (const PolyColumn& c : contacts.point_data) EXPECT_EQ(rows_for(contact_columns(), c.name), 1) << c.name;
}

}  // namespace
}  // namespace talus
