// series.csv: one row of scalars per output time; which column is what stands in core/io/series_columns.cpp. Who calls
// it: cases/ (run). Invariants: the columns are decided once by the scene; numbers are the shortest text that reads
// back to the same double; rows appear whole; a resumed run ends with the bytes of the uninterrupted one (rates over an
// interval are taken from values in the file itself).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/frame/averages.hpp"
#include "core/frame/frame.hpp"
#include "core/frame/plane_count.hpp"
#include "core/io/watched_file.hpp"
#include "core/scene/scene.hpp"

namespace talus {

/// Which columns exist besides those that always do.
struct SeriesLayout {
  bool inserted = false, wall_contacts = false, energies = false, rotation = false, friction = false,
       superquadrics = false, sizes = false;
  std::vector<const AverageQuantity*> averages = averages_of(Scene{});  ///< of each region
  std::vector<std::string> walls, planes, regions;                      ///< names
  std::vector<std::string> parts;                                       ///< columns of optional parts
  /// The layout of a scene; `walls` are all wall names in wall order (domain sides included).
  static SeriesLayout of(const Scene& scene, std::vector<std::string> walls);
  std::vector<std::string> columns() const;  ///< header, in order
};

/// Values of one row; vectors have the sizes of the layout.
struct SeriesRow {
  std::int64_t step = 0;
  double time = 0;  ///< [s]
  std::int64_t particles = 0, contacts = 0, wall_contacts = 0, safe_pairs = 0, inserted = 0, removed = 0;
  double kinetic_energy = 0;  ///< translation [J]
  double removed_mass = 0;    ///< cumulative [kg]
  Energies energies;
  std::vector<WallLoad> walls;
  std::vector<PlaneTotal> planes;
  std::vector<RegionAverage> regions;
  std::vector<double> parts;
};

class SeriesWriter {
 public:
  /// Creates the file with its header. Error{io}.
  SeriesWriter(const std::string& path, const SeriesLayout& layout);
  /// Opens an existing file, drops rows later than `last_step` and a torn last row. A missing file is created.
  /// CannotContinue: other columns, or rows that cannot be read. Error{io}.
  static SeriesWriter resume(const std::string& path, const SeriesLayout& layout, std::int64_t last_step);
  ~SeriesWriter();
  SeriesWriter(SeriesWriter&&) noexcept;
  SeriesWriter& operator=(SeriesWriter&&) noexcept;

  /// Appends one row. Error{io}: sizes that do not fit, a step not after last_step(), the file was deleted or changed
  /// by others, or a write failure (the file then still ends with the row before).
  void append(const SeriesRow& row);
  /// Of a run that goes on from a checkpoint without the rows before: the means of the first row count from here.
  void start_from(const SeriesRow& row);
  void check() const;  ///< Error{io} if the file was deleted, replaced or changed by others
  std::int64_t last_step() const noexcept { return last_step_; }  ///< -1 if there is no row

 private:
  SeriesWriter() = default;
  std::string path_;
  SeriesLayout layout_;
  WatchedFile file_;
  std::uint64_t size_ = 0;  ///< bytes of whole rows
  std::int64_t last_step_ = -1;
  std::optional<SeriesRow> previous_;  ///< what the means need of it
};

/// Error{io} if a series is damaged: no header, a row with another number of entries, an entry that is no number, a
/// step that does not come after the one before, a last row that is cut off.
void check_series(const std::string& path);

}  // namespace talus
