// The columns of series.csv, a line per quantity: name, unit, kind, meaning, when it is there, its value. The writer,
// the help and the reference loop over these tables. Who uses it: core/io (series, output_tables). To add a quantity,
// write its line in series_columns.cpp, or in core/frame/averages.cpp for an average over a region.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/io/series.hpp"

namespace talus {

using SeriesValue = std::variant<std::int64_t, double, Vec3>;

/// What a value is made of: its source in this row and, for means, in the row before.
template <class T>
struct SeriesAt {
  const T &now, &before;
  double interval;  ///< since the row before [s]; 0 in the first row
  double rate(double later, double earlier) const { return interval > 0 ? (later - earlier) / interval : 0.0; }
};

/// T: SeriesRow, or what a row has for each wall, plane or region.
template <class T>
struct SeriesQuantity {
  std::string_view name;  ///< "wall.<wall>.force_{x,y,z}": <wall> stands for the name, {x,y,z} for three columns
  std::string_view unit, kind, doc;
  SeriesValue (*value)(const SeriesAt<T>&);
  bool (*wanted)(const SeriesLayout&) = nullptr;  ///< nullptr: always
};

std::span<const SeriesQuantity<SeriesRow>> run_quantities() noexcept;
std::span<const SeriesQuantity<WallLoad>> wall_quantities() noexcept;
std::span<const SeriesQuantity<PlaneTotal>> plane_quantities() noexcept;

/// Names of the columns that a pattern stands for.
std::vector<std::string> column_names(std::string_view pattern, std::string_view name);
/// The pattern of an average over a region.
std::string pattern_of(const AverageQuantity& average);

}  // namespace talus
