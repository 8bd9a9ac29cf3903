// Many grains at once: the bits of a grain do not depend on instruction set or neighbours; balances close; the answer
// is that of the iterated solver of one grain, to first order in the step; nothing overshoots.
#include "kernels/conversion/grain_batch.hpp"

#include <fmt/format.h>

#include <bit>
#include <random>
#include <vector>

#include "core/base/error.hpp"
#include "core/conversion/bed_math.hpp"
#include "core/conversion/film.hpp"
#include "kernels/kernel_table.hpp"
#include "tests/conversion/grain_support.hpp"

namespace talus::conversion {
namespace {
using namespace test;

/// Wood that dries, decomposes by three reactions and burns.
Matter burning_wet_wood(Drying drying, double moisture = 0.3, bool burns = true) {
  Matter m = inert(600, 1500, 0.2);
  m.heat_capacity[0] = Property::constant(4180);
  m.heat_capacity[1] = Property::polynomial({1500, 1.0}, 273.15, 200, 2000);
  m.solids.clear();
  add_scheme(m, "di_blasi");
  m.solids[0].initial = 0.99 - moisture;
  m.solids.push_back({"moisture", Kind::moisture, moisture, {}});
  m.solids.push_back({"ash", Kind::ash, 0.01, {}});
  m.drying = {drying, 0, 0, 373.15, 2.26e6};
  if (burns) m.char_reactions = {{CharReaction::Oxidant::oxygen, 1.715, 1, 74830, 4.3, 28186}};
  m.shrinkage = {0.1, 0.3, 0.9};
  m.gas_convection = m.blowing = true;
  return checked(m);
}

/// Grains with their columns.
struct Bed {
  Matter matter;
  BedTables tables;
  std::vector<std::vector<double>> rows;
  std::vector<double*> row;
  std::vector<double> in, out, scratch;
  std::vector<BedTotals> start;
  std::vector<double> sums;  ///< [out column] over grains and steps
  GrainBatch batch;

  Bed(const Matter& m, int shells, std::size_t grains, double radius, double temperature, double spread = 0)
      : matter(m), tables(m, shells, k_air, FilmLaw::ranz_marshall) {
    const BedMatter& b = tables.matter();
    const auto stride = (grains + 7) / 8 * 8;
    for (std::size_t k = 0; k < grains; ++k) {
      rows.emplace_back(static_cast<std::size_t>(bed_row(b).size));
      const double x = spread * static_cast<double>(k) / static_cast<double>(grains);
      tables.begin(radius * (1 + x), temperature * (1 + 0.2 * x), rows.back().data());
      start.push_back(bed_totals(matter, b, rows.back().data()));
    }
    for (auto& r : rows) row.push_back(r.data());
    in.assign(k_bed_in * stride, 0.0);
    out.assign(static_cast<std::size_t>(k_out_released + b.gases) * stride, 0.0);
    scratch.assign(static_cast<std::size_t>(bed_scratch(b)) + 8, 0.0);
    sums.assign(static_cast<std::size_t>(k_out_released + b.gases), 0.0);
    batch.grains = static_cast<long>(grains);
    batch.row = row.data();
    batch.in = in.data();
    batch.out = out.data();
    batch.stride = static_cast<long>(stride);
    auto at = reinterpret_cast<std::uintptr_t>(scratch.data());
    batch.scratch = reinterpret_cast<double*>((at + 63) / 64 * 64);
    set(k_in_gas, 300), set(k_in_wall, 300), set(k_in_film, -1), set(k_in_sees, 1);
    set(k_in_molar, conversion::k_nitrogen.molar), set(k_in_pressure, 101325);
  }
  void set(BedIn column, double value, double more = 0) {
    for (std::size_t k = 0; k < row.size(); ++k)
      in[static_cast<std::size_t>(column * batch.stride) + k] = value + more * static_cast<double>(k);
  }
  void run(const char* isa, double dt, int steps) {
    batch.dt = dt;
    for (int n = 0; n < steps; ++n) {
      grain_solver(isa)(tables.matter(), batch);
      for (std::size_t c = 0; c < sums.size(); ++c)
        for (std::size_t k = 0; k < row.size(); ++k) sums[c] += out_of(static_cast<int>(c), k);
    }
  }
  double out_of(int column, std::size_t k) const { return out[static_cast<std::size_t>(column * batch.stride) + k]; }
  double temperature(std::size_t k, int shell) const {
    return rows[k][static_cast<std::size_t>(bed_row(tables.matter()).temperature + shell)];
  }
};

/// Hot air that differs from grain to grain.
void furnace(Bed& b) {
  b.set(k_in_gas, 900, 15);
  b.set(k_in_wall, 1200, 10);
  b.set(k_in_velocity, 1, 0.1);
  b.set(k_in_oxygen, 0.2, 0.001);
  b.set(k_in_contact, 1e-3, 1e-4);
  b.set(k_in_contact_heat, 0.8, 0.01);
}

TEST(GrainBatch, ExponentialAndLogarithmHaveTheBitsOfTheScalarOnes) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> wide(-700, 700), near(-2, 2);
  for (int k = 0; k < 200000; ++k) {
    const double x = k % 2 == 0 ? wide(random) : near(random);
    ASSERT_EQ(std::bit_cast<std::uint64_t>(bed::exponential<shapes::Plain>(x)),
              std::bit_cast<std::uint64_t>(det::exp(x)))
        << x;
    const double y = det::exp(0.5 * x);
    if (y < 1e-300) continue;
    ASSERT_EQ(std::bit_cast<std::uint64_t>(bed::logarithm<shapes::Plain>(y)), std::bit_cast<std::uint64_t>(det::log(y)))
        << y;
  }
  EXPECT_EQ(bed::exponential<shapes::Plain>(-1e300), det::exp(-700));
  EXPECT_EQ(bed::exponential<shapes::Plain>(1e300), det::exp(700));
}

TEST(GrainBatch, PowersOfTwoKeepTheirDigitsBesideOne) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> exponent(-45, 2.8);
  for (int k = 0; k < 100000; ++k) {
    const double x = -std::exp(2.302585 * exponent(random));  // -1e-45 to -600
    const auto p = bed::power_of_two<shapes::Plain>(x);
    ASSERT_NEAR((p.scale + p.more) / std::exp2(x), 1, 6e-12) << x;
    ASSERT_NEAR(((1 - p.scale) - p.more) / -std::expm1(x * det::k_ln2), 1, 2e-11) << x;
  }
  const auto least = bed::power_of_two<shapes::Plain>(-1e300);
  EXPECT_EQ(least.scale + least.more, std::exp2(-1000));
}

TEST(GrainBatch, TracesOfASolidReactAwaySoThatItEndsAtZero) {
  const Matter m = burning_wet_wood(Drying::boiling);
  Bed b(m, 10, 3, 0.002, 300, 0.5);
  furnace(b);
  b.run("scalar", 0.02, 6000);
  const BedMatter& t = b.tables.matter();
  const BedRow at = bed_row(t);
  for (const auto& row : b.rows)
    for (int s = 0; s < t.solids; ++s)
      for (int i = 0; i < t.shells; ++i) {
        const double x = row[static_cast<std::size_t>(at.mass + s * t.shells + i)];
        const double r = row[static_cast<std::size_t>(at.radius0)], first = 600 * t.volume[i] * (r * r * r);
        ASSERT_TRUE(x == 0 || x > 1e-16 * first) << s << ' ' << i << ' ' << x / first;
        if (s == static_cast<int>(m.solid("wood")) || s == t.moisture) {
          ASSERT_EQ(x, 0);
        }
      }
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(b.out_of(k_out_ash, k) / b.start[k].ash, 1, 1e-14) << "ash stays";
}

TEST(GrainBatch, GivesEachGrainTheSameBitsOnEveryInstructionSetAndBesideEveryNeighbour) {
  for (const Drying law : {Drying::boiling, Drying::equilibrium}) {
    const Matter m = burning_wet_wood(law);
    Bed first(m, 13, 21, 0.003, 300, 0.8);
    furnace(first);
    first.run("scalar", 0.01, 1500);
    EXPECT_LT(first.out_of(k_out_mass, 0), 0.5 * first.start[0].mass) << "the grains have burnt in part";
    for (const Isa isa : available_isas()) {
      Bed other(m, 13, 21, 0.003, 300, 0.8);
      furnace(other);
      other.run(isa_name(isa), 0.01, 1500);
      EXPECT_EQ(other.rows, first.rows) << isa_name(isa);
      EXPECT_EQ(other.sums, first.sums) << isa_name(isa);
      // one grain alone, whose lanes are all itself
      Bed alone(m, 13, 1, 0.003, 300);
      furnace(alone);
      alone.run(isa_name(isa), 0.01, 1500);
      EXPECT_EQ(alone.rows[0], first.rows[0]) << isa_name(isa);
    }
  }
}

TEST(GrainBatch, HeatMassAndElementsCloseToRounding) {
  for (const char* scheme : {"di_blasi", "wagenaar", "debiagi"}) {
    Matter m = inert(600, 1500, 0.2);
    m.solids.clear();
    add_scheme(m, scheme);
    const bool mixed = std::string(scheme) == "debiagi";
    if (mixed) {
      m.reference_temperature = 298.15;
      m.solids[m.solid("CELL")].initial = 0.45;
      m.solids[m.solid("XYHW")].initial = 0.25;
      m.solids[m.solid("LIGO")].initial = 0.1;
    } else {
      m.solids[m.solid("wood")].initial = 0.8;
    }
    m.solids.push_back({"moisture", Kind::moisture, 0.19, {}});
    m.solids.push_back({"ash", Kind::ash, 0.01, {}});
    m.drying = {Drying::equilibrium, 0, 0, 373.15, 2.26e6};
    m.char_reactions = {{CharReaction::Oxidant::oxygen, 1.715, 1, 74830, 4.3, 28186},
                        {CharReaction::Oxidant::steam, 3.42, 1, 129700, 4.3, 28186}};
    m.shrinkage = {0.1, 0.3, 0.9};
    m.gas_convection = m.blowing = true;
    m = checked(m);
    Bed b(m, 10, 3, 0.002, 300, 0.5);
    furnace(b);
    b.set(k_in_steam, 0.05);
    b.run("scalar", 0.01, 1200);
    BedTotals before, after;
    for (std::size_t k = 0; k < 3; ++k) {
      const BedTotals t = bed_totals(m, b.tables.matter(), b.rows[k].data());
      before.heat += b.start[k].heat, after.heat += t.heat;
      before.mass += b.start[k].mass, after.mass += t.mass;
      for (int e = 0; e < k_bed_elements; ++e)
        before.elements[e] += b.start[k].elements[e], after.elements[e] += t.elements[e];
    }
    const auto at = [](int k) { return static_cast<std::size_t>(k); };
    EXPECT_LT(after.mass, 0.7 * before.mass) << scheme;
    const double turned = std::fabs(b.sums[at(k_out_heat_in)]) + std::fabs(b.sums[at(k_out_reaction)]);
    EXPECT_LT(std::fabs(after.heat - before.heat - b.sums[at(k_out_heat_in)] - b.sums[at(k_out_reaction)] +
                        b.sums[at(k_out_with_gas)]),
              1e-11 * turned)
        << scheme;
    for (int e = 0; e < k_bed_elements; ++e)
      EXPECT_LT(std::fabs(after.elements[e] - before.elements[e] + b.sums[at(k_out_gone + e)]), 1e-12 * before.mass)
          << scheme << ' ' << k_element_names[e];
    double released = 0;
    for (int g = 0; g < b.tables.matter().gases; ++g) released += b.sums[at(k_out_released + g)];
    for (const int k : {k_out_oxygen, k_out_carbon_dioxide, k_out_steam}) released -= b.sums[at(k)];
    EXPECT_LT(std::fabs(after.mass - before.mass + released), 1e-9 * before.mass) << scheme;
  }
}

/// Centre temperature and mass beside those of the iterated solver with a fine step.
struct Error2 {
  double kelvin = 0, mass = 0;
};
Error2 error_of(const Matter& m, double dt, double until, double film, double hot) {
  Bed b(m, 20, 1, 0.005, 300);
  b.set(k_in_gas, hot), b.set(k_in_wall, hot), b.set(k_in_film, film), b.set(k_in_oxygen, 0.0);
  GrainForm form;
  form.radius = 0.005;
  Grain<double> g(m, form, 300, {});
  Surroundings<double> s = gas_at(hot, film);
  s.emissivity = 1;
  s.wall_temperature = hot;
  g.begin(s);
  Error2 e;
  const double fine = 0.02;
  const int every = 50;
  for (int n = 1; n * fine * every <= until; ++n) {
    for (int k = 0; k < every; ++k) g.advance(fine, s, s, {});
    b.run("scalar", dt, static_cast<int>(fine * every / dt + 0.5));
    e.kelvin = std::max(e.kelvin, std::fabs(b.out_of(k_out_centre, 0) - g.centre()));
    e.mass = std::max(e.mass, std::fabs(b.out_of(k_out_mass, 0) - g.totals().mass) / g.at_start().mass);
  }
  return e;
}

TEST(GrainBatch, AgreesWithTheIteratedSolverToFirstOrderInTheStep) {
  const Matter m = burning_wet_wood(Drying::boiling, 0, false);
  const Error2 a = error_of(m, 0.2, 60, 60, 900), b = error_of(m, 0.1, 60, 60, 900), c = error_of(m, 0.05, 60, 60, 900);
  std::printf("    dry wood, 10 mm, 900 K: step 0.2 s %.3f K %.5f, 0.1 s %.3f K %.5f, 0.05 s %.3f K %.5f\n", a.kelvin,
              a.mass, b.kelvin, b.mass, c.kelvin, c.mass);
  EXPECT_LT(c.kelvin, 2);
  EXPECT_LT(c.mass, 0.002);
  EXPECT_GT(a.kelvin / b.kelvin, 1.6);
  const Matter wet = burning_wet_wood(Drying::boiling, 0.3, false);
  const Error2 d = error_of(wet, 0.1, 60, 60, 900), e = error_of(wet, 0.05, 60, 60, 900);
  std::printf("    wet wood: step 0.1 s %.3f K %.5f, 0.05 s %.3f K %.5f\n", d.kelvin, d.mass, e.kelvin, e.mass);
  EXPECT_LT(e.kelvin, 12);
  EXPECT_LT(e.mass, 0.01);
}

TEST(GrainBatch, HeatsASphereAsTheClosedFormSays) {
  // 1 mm sphere, 293 K into 773 K, Bi 1.458: centre 481.78 K, surface 616.96 K after half a second
  const Matter m = checked(inert(540, 1800, 0.12));
  const auto errors = [&](double dt) {
    Bed b(m, 20, 1, 0.0005, 293);
    b.set(k_in_gas, 773), b.set(k_in_film, 350), b.set(k_in_sees, 0);
    b.run("scalar", dt, static_cast<int>(0.5 / dt + 0.5));
    return std::pair{b.out_of(k_out_centre, 0) - 481.78, b.out_of(k_out_surface, 0) - 616.96};
  };
  const auto [coarse, surface] = errors(0.005);
  const auto [fine, unused] = errors(0.0025);
  EXPECT_LT(std::fabs(coarse), 1.7);
  EXPECT_LT(std::fabs(surface), 1.0);
  EXPECT_LT(std::fabs(fine), 0.6 * std::fabs(coarse));
}

TEST(GrainBatch, NothingOvershootsWhateverTheStep) {
  Matter stiff = inert(600, 1500, 0.2);
  stiff.solids = {{"wood", Kind::fuel, 0.6, {}}, {"water", Kind::moisture, 0.3, {}}, {"ash", Kind::ash, 0.1, {}}};
  stiff.gases = {{"steam", Composition{0, 0, 0, 0, 1}}, {"gas", {}}};
  stiff.reactions = {{"drying", 1, false, 5.13e10, 0, 88e3, 2.26e6, {}, {{0, 1}}},
                     {"pyrolysis", 0, false, 1e10, 0, 60e3, 4e5, {}, {{1, 1}}}};
  stiff = checked(stiff);
  const Matter wet = burning_wet_wood(Drying::equilibrium), dry = checked(inert(600, 1500, 0.2));
  // Bi = h R / (3 k) from 1e-4 to 67, both ways over 2000 K
  for (const double film : {0.01, 10.0, 1e4})
    for (const double dt : {1e-4, 0.1, 1.0})
      for (const Matter* m : std::initializer_list<const Matter*>{&stiff, &wet, &dry}) {
        const double cold = 300, hot = 2300;
        for (const bool cools : {false, true}) {
          if (cools && m != &dry) continue;
          if (m == &stiff && dt > 0.1) continue;  // longer than heat takes through a shell: see bed_step.hpp
          Bed b(*m, 20, 2, 0.004, cools ? hot : cold);
          const double around = cools ? cold : hot;
          b.set(k_in_gas, around), b.set(k_in_wall, around), b.set(k_in_film, film);
          double low = 1e9, high = 0;
          for (int n = 0; n < 300; ++n) {
            b.run("scalar", dt, 1);
            for (int i = 0; i < 20; ++i)
              low = std::min(low, b.temperature(0, i)), high = std::max(high, b.temperature(0, i));
          }
          const std::string what = fmt::format("film {} step {} {}", film, dt,
                                               m == &stiff ? "stiff"
                                               : m == &wet ? "wet"
                                                           : "dry");
          // evaporation at the surface cools it, and Arrhenius drying is not held by a boiling point
          EXPECT_GT(low, m == &dry ? cold - 1e-6 : cold - 60) << what;
          EXPECT_LT(high, m == &dry ? hot + 1e-6 : 1.01 * hot) << what;
          for (const double x : b.rows[0]) ASSERT_TRUE(std::isfinite(x)) << what;
          for (const int k : {k_out_mass, k_out_moisture, k_out_fuel, k_out_char, k_out_ash})
            EXPECT_GE(b.out_of(k, 0), 0);
        }
      }
}

TEST(GrainBatch, RefusesWhatItDoesNotCompute) {
  Matter m = inert(600, 1500, 0.2);
  m.melting = {1000, 1100, 2e5};
  m = checked(m);
  EXPECT_THROW(BedTables(m, 20, k_air, FilmLaw::ranz_marshall), Error);
  EXPECT_THROW(BedTables(checked(inert(600, 1500, 0.2)), 33, k_air, FilmLaw::ranz_marshall), Error);
}

}  // namespace
}  // namespace talus::conversion
