// The part "conversion" in its two halves: conversion.cpp (columns, comings and goings, sizes, ledger) and
// conversion_step.cpp (a step of the grains). Invariants: I3 (totals over fixed blocks of rows), I7; a step that fails
// leaves the present numbers as they were.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "kernels/conversion/grain_batch.hpp"
#include "scheduler/parts/conversion.hpp"
#include "scheduler/parts/conversion_bodies.hpp"
#include "scheduler/parts/doors.hpp"

namespace talus {

/// What converts of a material.
struct ConvertingKind {
  std::shared_ptr<const conversion::GrainJob> job;
  std::unique_ptr<conversion::BedTables> tables;
  int size = 0;                    ///< of the solver's row
  std::vector<std::size_t> gases;  ///< its gases among those of all materials
  bool burns[3] = {};              ///< takes O2, CO2, H2O
  double shares = 1;               ///< reactions that take the same of them
};

class Conversion final : public Part, public GrainInside {
 public:
  Conversion(const Rules& rules, const ConversionSettings& settings);

  std::string name() const override { return "conversion"; }
  bool resizes() const override { return s_.resizes; }
  double step_limit(const PartView& w) const override;
  void add_columns(Columns& columns) override;
  std::vector<PartNode> nodes() override;
  void appended(const Rows& rows, Row first, const NewParticles& a) override;
  void removed(const Rows& rows, Row i) override;
  void take_back() override;
  void sizes(const PartView& w, const Chunk& c, const RowSizes& s) const override;
  std::vector<PartValue> values(const PartView& w) const override;
  std::vector<std::string> advice(const PartView& w) const override;
  std::vector<std::uint8_t> save() const override;
  void load(std::span<const std::uint8_t> bytes, const std::string& where) override;
  GrainSurface surface(Row i) const override;
  bool condenses(const Rows& rows, Row i) const override;

  /// Output columns of the solver that particle files show.
  struct Shown {
    const char *name, *unit;
    int column;
  };
  static constexpr std::size_t k_columns = 8;
  static const Shown k_shown[k_columns];
  /// Of the solver's output, what the ledger sums: heat, gas taken (O2, CO2, H2O), elements, what goes to gas cells by
  /// extents; then the gases, then the excess of its step.
  static constexpr std::size_t k_fixed_books = 13;
  static const int k_books[k_fixed_books];
  enum ShownAt : std::size_t { k_shown_surface = 1, k_shown_masses = 3, k_shown_char = 6 };  ///< places in k_shown
  static constexpr std::size_t k_books_reaction = 2, k_books_with_gas = 3, k_books_taken = 4, k_books_standard = 12;

 private:
  using Kind = ConvertingKind;
  using Totals = conversion::BedTotals;
  /// Behind the solver's numbers in a row.
  enum Own : int { k_radius_from, k_radius_to, k_mass_from, k_mass_to, k_own };
  struct Batch;  ///< what a batch of rows goes in with

  double* row(Column<double>& c, Row i) const { return c.data() + static_cast<std::ptrdiff_t>(width_) * i; }
  const double* row(const Column<double>& c, Row i) const { return c.data() + static_cast<std::ptrdiff_t>(width_) * i; }
  double* book(Row i) { return books_.data() + static_cast<std::ptrdiff_t>(books_width_) * i; }
  /// Of the grain that row i leads; null of the other rows of bodies.
  const Kind* kind_of(const Rows& rows, Row i) const {
    if (!rows.leads(i)) return nullptr;
    const Kind& k = kinds_[rules_.has.materials ? rows.material[i] : 0];
    return k.job ? &k : nullptr;
  }
  /// How many spheres the grain that row i leads counts as.
  double number_of(const Rows& rows, Row i) const {
    const std::int32_t b = rows.body_of(i);
    return b < 0 ? 1.0 : shapes_[static_cast<std::size_t>(rows.bodies.shape[static_cast<std::size_t>(b)])].number;
  }
  Row rows_of(const Rows& rows, Row i) const {
    return static_cast<Row>(shape_of(rules_, rows.bodies, rows.body_of(i)).spheres.size());
  }
  /// Of all of them, from that of one.
  static GrainSurface all_of(GrainSurface s, double number) {
    return {number * s.capacity, number * s.inner, s.conductivity, s.emissivity, number * s.carried};
  }
  double radius_of(const Rows& rows, Row i) const;  ///< of one of them, as the row is now [m]
  void check_mass(const Rows& rows, Row i, double mass) const;
  void share_with_rows(const PartView& w, Row i);
  static void add(Totals& to, const Totals& t, double sign);
  void add_kind(std::size_t k);
  void check_surroundings(const Kind& kind, const std::string& material) const;
  GrainSurface first_surface(const Kind& kind, const double* own, double radius, double temperature) const;

  // conversion_step.cpp
  void advance(const PartView& w, Row lo, Row hi);
  void advance(const PartView& w, const Kind& kind, const std::vector<Row>& rows);
  void surroundings(const PartView& w, const Kind& kind, Batch& b) const;
  void exchanged(const PartView& w, const Kind& kind, Row i, std::size_t k, Batch& b) const;
  void take(const Kind& kind, double number, Row i, const double* out, std::size_t stride);
  void judge(const PartView& w) const;
  void finish(const PartView& w);
  void step_with_heat(const PartView& w);
  std::vector<GasUptake> uptakes(const PartView& w, const GasCells& gas) const;
  double outermost(const Kind& kind, Row i) const;  ///< temperature of that shell [K]
  void give(const PartView& w, GasCells& gas);
  void swap();

  const Rules& rules_;
  const ConversionSettings s_;
  const GrainSolver solver_;
  const bool heated_;  ///< what reaches the surfaces is the part heat's
  const bool cells_;   ///< the gas around is that of the part gas
  std::vector<Kind> kinds_;
  std::vector<EqualSpheres> shapes_;  ///< of bodies
  std::vector<std::string> gases_;
  int width_ = 0, books_width_ = 0;
  Column<double> now_, next_, books_;
  Column<double> shown_[k_columns], shown_next_[k_columns];
  Column<double> surface_, surface_next_;  ///< GrainSurface
  std::vector<double> outside_;            ///< by row: surface temperature that others see, of the present step [K]
  std::vector<double> condensed_;          ///< by row: steam that came in it [kg]
  std::vector<double> totals_, totals_before_;  ///< as k_books, then gases
  Totals come_;                                 ///< with grains, less what went with them
  const Clock* clock_ = nullptr;
  std::int64_t last_step_ = -1;
};

}  // namespace talus
