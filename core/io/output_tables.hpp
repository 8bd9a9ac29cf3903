// What a run writes, as tables: files of its folder, columns of the time series and of frames, with unit, reference
// point and sign. Who calls it: cases/ (talus help output, the reference). Invariant: every file and column that a run
// can write has one row, and every row is one that a run can write (tests/io/output_tables_test.cpp).
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace talus {

/// In names, <wall>, <plane> and <region> stand for names of the scene, <N> for a number, and {a,b} for each of the
/// words.
struct OutputFile {
  std::string_view name, key, doc;  ///< key: of the scene, that asks for it
};
struct OutputColumn {
  std::string name;
  std::string_view unit;
  std::string_view kind;  ///< sum, mean or moment (core/io/series_columns.hpp); "" for frames
  std::string_view doc;   ///< with reference point and sign
};

std::span<const OutputFile> output_files() noexcept;
std::span<const OutputColumn> series_columns();
std::span<const OutputColumn> frame_columns();    ///< of particles
std::span<const OutputColumn> contact_columns();  ///< of contacts

/// Does a name that was written fit a name of the tables?
bool fits(std::string_view pattern, std::string_view name);

}  // namespace talus
