// What the readers of STL, OBJ and PLY have in common: the mesh as it stands in the file, numbers in every notation
// that exporters write, and errors with the place in the file. Who calls it: core/io/mesh_*.cpp. Invariants: a reader
// gets bytes and touches no file; numbers are correctly rounded to double, independent of the locale; memory is bounded
// by the bytes given; every error is one printable line.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/types.hpp"

namespace talus::mesh_io {

/// Coordinates as in the file, polygons already cut into triangles.
struct RawMesh {
  std::vector<Vec3> points;
  std::vector<std::array<std::int32_t, 3>> facets;
  double unit = 0x1p-52;           ///< one unit in the last place of the largest coordinate, relative to it
  std::vector<std::string> notes;  ///< oddities that were read over
};

/// Readers of the three formats. `name` stands for the file in messages. Error{scene}.
RawMesh parse_stl(std::string_view bytes, const std::string& name);
RawMesh parse_obj(std::string_view bytes, const std::string& name);
RawMesh parse_ply(std::string_view bytes, const std::string& name);

/// Error{scene} at a line of the file (from 1); line 0: the file as a whole.
[[noreturn]] void fail(const std::string& name, std::int64_t line, const std::string& what,
                       const std::string& cure = {});

/// The text in quotes, shortened and printable.
std::string quoted(std::string_view text);
/// True if equal but for upper and lower case; `lower` is in lower case.
bool same_word(std::string_view text, std::string_view lower) noexcept;
bool is_blank(char c) noexcept;  ///< space or control character that only separates, within a line

/// A finite decimal number: sign, leading or trailing point, exponents with e, d or q (Fortran), also the three digits
/// without a letter that Fortran writes (1.5-101). Below the range: 0. `digits`: significant digits as written, 0 of a
/// whole number, which may be exact.
bool parse_number(std::string_view text, double& value, int* digits = nullptr) noexcept;
/// Why a text is no number, for messages.
std::string why_no_number(std::string_view text);

/// Estimates from the digits of a text file how fine its coordinates are: see unit().
class WrittenDigits {
 public:
  void see(double value, int digits) noexcept;
  /// Relative to the largest coordinate. Whole numbers and those of up to five digits count as exact; with more the
  /// longest number tells the format, and if every number is one of single precision, to its digits, so is the file.
  double unit() const noexcept;

 private:
  int most_ = 0;
  double largest_ = 0;
  bool single_ = true;
};

/// Text without a byte order mark. Error{scene} for UTF-16 and for compressed files.
std::string_view plain_text(std::string_view bytes, const std::string& name);

/// Lines that end with LF, CR LF or CR.
class Lines {
 public:
  explicit Lines(std::string_view text) noexcept : text_(text) {}
  bool next(std::string_view& line) noexcept;
  std::int64_t number() const noexcept { return number_; }
  std::size_t position() const noexcept { return position_; }  ///< of the first byte after the line and its end

 private:
  std::string_view text_;
  std::size_t position_ = 0;
  std::int64_t number_ = 0;
};

/// Words of a line, separated by blanks.
class Words {
 public:
  explicit Words(std::string_view line) noexcept : rest_(line) {}
  /// The next word; empty at the end.
  std::string_view next() noexcept;

 private:
  std::string_view rest_;
};

/// Polygons of OBJ and PLY, corner by corner.
struct Polygons {
  std::vector<std::int64_t> corners;  ///< indices of vertices from 0, not yet checked
  std::vector<std::size_t> end;       ///< of each polygon in corners
  std::vector<std::int64_t> line;     ///< of each polygon; 0 in binary files
};

/// Cuts the polygons into triangles of `mesh`. `first`: the number that the file gives its first vertex. Error{scene}:
/// a corner without a vertex, a vertex that is not finite, a polygon that crosses itself.
void add_polygons(RawMesh& mesh, const Polygons& polygons, int first, const std::string& name);

}  // namespace talus::mesh_io
