// The solver is a template over its value: two grains in one value do bit for bit what each does alone.
#include "tests/conversion/grain_support.hpp"

namespace talus::conversion {
namespace {
using namespace test;

/// A batch of two lanes with what a SIMD type has: arithmetic, comparison to a mask, selection.
struct Two {
  double a, b;
  Two() = default;
  Two(double x) : a(x), b(x) {}
  Two(double x, double y) : a(x), b(y) {}
};
struct Mask {
  bool a, b;
};
Two operator+(Two x, Two y) { return {x.a + y.a, x.b + y.b}; }
Two operator-(Two x, Two y) { return {x.a - y.a, x.b - y.b}; }
Two operator*(Two x, Two y) { return {x.a * y.a, x.b * y.b}; }
Two operator/(Two x, Two y) { return {x.a / y.a, x.b / y.b}; }
Mask less(Two x, Two y) { return {x.a < y.a, x.b < y.b}; }
Mask both(Mask x, Mask y) { return {x.a && y.a, x.b && y.b}; }
Two select(Mask m, Two x, Two y) { return {m.a ? x.a : y.a, m.b ? x.b : y.b}; }
Two square_root(Two x) { return {heat::square_root(x.a), heat::square_root(x.b)}; }
Two cube_root(Two x) { return {heat::cube_root(x.a), heat::cube_root(x.b)}; }
Two exponential(Two x) { return {heat::exponential(x.a), heat::exponential(x.b)}; }
Two power(Two x, double y) { return {heat::power(x.a, y), heat::power(x.b, y)}; }

Matter burning_wet_wood() {
  Matter m = inert(600, 1500, 0.2);
  m.solids.clear();
  add_scheme(m, "di_blasi");
  m.solids[0].initial = 0.69;
  m.solids.push_back({"moisture", Kind::moisture, 0.3, {}});
  m.solids.push_back({"ash", Kind::ash, 0.01, {}});
  m.drying = {Drying::equilibrium, 0, 0, 373.15, 2.26e6};
  m.char_reactions = {{CharReaction::Oxidant::oxygen, 1.715, 1, 74830, 4.3, 28186}};
  m.shrinkage = {0.1, 0.3, 0.9};
  m.gas_convection = m.blowing = true;
  return checked(m);
}

TEST(Lanes, DoWhatOneGrainDoesBitForBit) {
  const Matter m = burning_wet_wood();
  const auto surroundings = [](auto hot) {
    Surroundings<decltype(hot)> s;
    s.film = 100;
    s.gas_temperature = hot;
    s.emissivity = 1;
    s.wall_temperature = hot;
    return s;
  };
  const auto air = [](auto film) {
    GasAround<decltype(film)> g;
    g.film = film;
    g.oxygen = 0.1;
    return g;
  };
  const GrainForm form{heat::Shape::sphere, 0.005, 1, 12};
  Grain<double> one(m, form, 300, {}), other(m, form, 320, {});
  Grain<Two> pair(m, form, Two(300, 320), {});
  one.begin(surroundings(1100.0));
  other.begin(surroundings(1300.0));
  pair.begin(surroundings(Two(1100, 1300)));
  for (int n = 0; n < 600; ++n) {
    one.advance(0.1, surroundings(1100.0), surroundings(1100.0), air(0.1));
    other.advance(0.1, surroundings(1300.0), surroundings(1300.0), air(0.2));
    pair.advance(Two(0.1), surroundings(Two(1100, 1300)), surroundings(Two(1100, 1300)), air(Two(0.1, 0.2)));
  }
  for (std::size_t i = 0; i < form.shells; ++i) {
    EXPECT_EQ(pair.state.temperature[i].a, one.state.temperature[i]);
    EXPECT_EQ(pair.state.temperature[i].b, other.state.temperature[i]);
    EXPECT_EQ(pair.state.shells.face[i + 1].a, one.state.shells.face[i + 1]);
  }
  for (std::size_t k = 0; k < one.state.mass.size(); ++k) {
    EXPECT_EQ(pair.state.mass[k].a, one.state.mass[k]);
    EXPECT_EQ(pair.state.mass[k].b, other.state.mass[k]);
  }
  EXPECT_LT(other.totals().fuel, 0.05 * other.at_start().fuel) << "the run must reach burning";
  EXPECT_GT(other.state.oxygen_taken, 0);
}

}  // namespace
}  // namespace talus::conversion
