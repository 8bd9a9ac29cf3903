// Rows of particles as text frames have them: columns with a meaning, checked values, id order. Who calls it:
// core/io/text_frames_*.cpp only.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/io/text_frames.hpp"
#include "core/tables/particle_text.hpp"

namespace talus::text_frames {

enum class Field { x, y, z, xs, ys, zs, vx, vy, vz, wx, wy, wz, radius, diameter, id, type, species, none };
constexpr std::size_t k_fields = static_cast<std::size_t>(Field::none);

/// Reads the rows of one file, frame by frame.
class Rows {
 public:
  Rows(particle_text::Lines& lines, const std::string& name, TextFrames& out) : lines_(lines), name_(name), out_(out) {}

  [[noreturn]] void fail(const std::string& what, const std::string& cure = {}) const;
  /// What the values of a row are; refuses columns that make no spheres, and others than those of the frame before.
  void columns(std::vector<Field> fields, const std::string& cure);
  /// `n` rows into the frame. `domain`: for positions in shares of the box.
  void read(Frame& frame, std::int64_t n, const std::optional<Domain>& domain);

  /// After the last frame: a file of one material has no column of materials.
  void finish();

  template <class T>
  T number(std::string_view text, std::string_view what) const {
    T value{};
    const auto state = particle_text::read_number(text, value);
    if (state == particle_text::NumberState::syntax) fail(fmt::format("{}: '{}' is not a number", what, shown(text)));
    if (state == particle_text::NumberState::range)
      fail(fmt::format("{}: '{}' is beyond the range of numbers", what, shown(text)));
    if constexpr (std::is_floating_point_v<T>)
      if (!(value - value == 0)) fail(fmt::format("{}: '{}' is not finite", what, shown(text)));
    return value;
  }

 private:
  bool has(Field f) const;
  void row(Frame& frame, const std::optional<Domain>& domain);
  /// Of a row's values; refuses what is no sphere, and a diameter that is not two radii.
  double radius_of(std::span<const double, k_fields> value) const;
  std::uint8_t material_of(std::string_view species);
  void into_id_order(Frame& frame) const;

  particle_text::Lines& lines_;
  const std::string& name_;
  TextFrames& out_;
  std::vector<Field> fields_;
  std::vector<std::string_view> values_;
};

}  // namespace talus::text_frames
