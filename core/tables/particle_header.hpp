// The row of names of a particle table, and how its lines are split. Who calls it: core/tables/particle_table.cpp.
#pragma once

#include <algorithm>
#include <deque>
#include <span>

#include "core/tables/particle_columns.hpp"
#include "core/tables/particle_text.hpp"

namespace talus::particle_text {

/// Splits lines into fields without their quotes.
class Splitter {
 public:
  explicit Splitter(char separator) : separator_(separator) {}
  char separator() const noexcept { return separator_; }
  std::span<const std::string_view> fields() const noexcept { return fields_; }

  /// False where a quote is not closed on the line.
  bool split(std::string_view line) {
    fields_.clear();
    unquoted_.clear();
    if (line.find('"') != std::string_view::npos) return split_quoted(line);
    if (separator_ == ' ') {
      split_blanks(line, fields_);
      return true;
    }
    while (true) {
      const std::size_t end = line.find(separator_);
      fields_.push_back(trim(line.substr(0, end)));
      if (end == std::string_view::npos) return true;
      line.remove_prefix(end + 1);
    }
  }

 private:
  bool split_quoted(std::string_view line);

  char separator_;
  std::vector<std::string_view> fields_;
  std::deque<std::string> unquoted_;  // keeps its places
};

struct Header {
  std::int64_t row = 0;
  std::vector<std::string> names;
  std::vector<ParticleColumn> meaning;  ///< of each field
  std::vector<std::string> unit;
  char separator = ',';
  bool first_row_read = false;  ///< the last line is a row of data already
  bool has(ParticleColumn c) const { return std::find(meaning.begin(), meaning.end(), c) != meaning.end(); }
  bool complete() const {
    return has(ParticleColumn::x) && has(ParticleColumn::y) && has(ParticleColumn::z) &&
           (has(ParticleColumn::radius) || has(ParticleColumn::diameter) || has(ParticleColumn::scale));
  }
};

/// Finds the row of names; the lines behind it are data. What is skipped or assumed is added to `notes`. Error{scene}
/// where there is no such row, a column is missing or its unit is not one that can be read as it is. `bodies`: rows
/// may be bodies without a column that says so.
Header read_header(Lines& lines, const std::string& name, std::vector<std::string>& notes, bool bodies = false);

bool is_comment(std::string_view line);

}  // namespace talus::particle_text
