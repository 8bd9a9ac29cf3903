// What a frame can hold, a line per quantity: name, unit, meaning, which scenes want it, its values and the way back
// from a file. Writers (VTP, VTKHDF, CSV), readers, help and reference loop over these tables. Who uses it: core/io,
// cases/. To add a quantity, write its line in quantities.cpp. Invariant: which columns exist follows from
// ParticleColumns alone, so that a frame without particles fits its file.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/frame/columns.hpp"
#include "core/frame/frame.hpp"

namespace talus {

struct Scene;

/// A column of particle frames.
struct ParticleQuantity {
  std::string_view name, unit, doc;  ///< doc: with reference point and sign
  int components;                    ///< 6: a symmetric tensor in VTK's order XX YY ZZ XY YZ XZ
  bool (*wanted)(const Scene&);      ///< nullptr: always
  bool (*held)(const Frame&);        ///< nullptr: always; does a frame that has grains hold it?
  ColumnValues (*values)(const Frame&);
  /// Puts the values of a file into a frame; nullptr: they follow from another quantity.
  void (*take)(Frame&, ColumnValues&&);
  std::string_view csv;  ///< names of its columns in a table of particles, "a,b,c"; "": not in tables
  bool forces = false;   ///< from contact forces, which mean nothing after a failed step
};
std::span<const ParticleQuantity> particle_quantities() noexcept;
/// Is a column of doubles in a file one of a part, which no table here knows, so that it is carried along by its name?
bool is_part_column(std::string_view name) noexcept;

/// A column of contact frames.
struct ContactQuantity {
  std::string_view name, unit, doc;
  void (*append)(ColumnValues&, const ContactRecord&);
  ColumnValues (*none)();  ///< no values, of the right type
  int components;
};
std::span<const ContactQuantity> contact_quantities() noexcept;

/// The particle quantities of a file.
class ParticleColumns {
 public:
  /// Those that are always there.
  ParticleColumns() = default;
  /// What it asks for; `example`: a frame of its run, for the columns of optional parts.
  static ParticleColumns of(const Scene& scene, const Frame& example);
  static ParticleColumns of(const Frame& frame);  ///< what it holds
  static ParticleColumns all();
  ParticleColumns without_forces() const;
  const std::vector<std::string>& extra() const noexcept { return extra_; }  ///< columns of optional parts
  const std::vector<std::string>& contact_extra() const noexcept { return contact_extra_; }  ///< the same of contacts
  /// `k`: index in particle_quantities().
  bool has(std::size_t k) const noexcept { return always(k) || ((chosen_ >> k) & 1U) != 0; }

 private:
  static bool always(std::size_t k) noexcept { return particle_quantities()[k].wanted == nullptr; }
  std::uint64_t chosen_ = 0;
  std::vector<std::string> extra_, contact_extra_;
};

/// Points with the given columns, as vertices. Error{io} if the frame lacks one of them.
PolyData particle_poly(const Frame& frame, const ParticleColumns& columns);
/// Triangles of all walls at their present pose; cell column "wall" = index of the wall.
PolyData wall_poly(const Frame& frame);
/// One point per contact.
PolyData contact_poly(const Frame& frame);
/// A point per body with id, shape, scale, mass, velocity, angular_velocity and orientation (a quaternion, as glyph
/// mappers take it).
PolyData body_poly(const Frame& frame);

/// Triples of numbers as vectors, and back.
std::vector<Vec3> vectors_of(const std::vector<double>& flat);
std::vector<double> flat_of(const std::vector<Vec3>& vectors);

}  // namespace talus
