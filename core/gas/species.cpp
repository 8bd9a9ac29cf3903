// See species.hpp.
#include "core/gas/species.hpp"

#include "core/base/det_math.hpp"
#include "core/base/types.hpp"

namespace talus::gas {

namespace {

constexpr SpeciesInfo k_info[k_gas_species] = {
    {"O2", 31.9988e-3, {0, 0, 2, 0}},   {"CO2", 44.0098e-3, {1, 0, 2, 0}}, {"CO", 28.0104e-3, {1, 0, 1, 0}},
    {"H2O", 18.01528e-3, {0, 2, 1, 0}}, {"H2", 2.01588e-3, {0, 2, 0, 0}},  {"CH4", 16.04276e-3, {1, 4, 0, 0}},
    {"tar", 78.11364e-3, {6, 6, 0, 0}}, {"N2", 28.0134e-3, {0, 0, 0, 2}},
};

/// a1..a6: cp/R = a1 + a2 T + ... + a5 T^4, h/R = a1 T + a2 T^2/2 + ... + a6.
struct Polynomial {
  double a[6];
};
struct Thermo {
  double split;  ///< [K]
  Polynomial low, high;
};

constexpr double k_r = k_gas_constant;
// Benzene: cp = -33.92 + 0.4739 T - 3.017e-4 T^2 + 7.13e-8 T^3 J/(mol K), enthalpy of formation 82.93 kJ/mol at 298.15
// K.
constexpr double k_tar_integral = -33.92 * 298.15 + 0.4739 / 2 * 298.15 * 298.15 -
                                  3.017e-4 / 3 * 298.15 * 298.15 * 298.15 +
                                  7.13e-8 / 4 * 298.15 * 298.15 * 298.15 * 298.15;
constexpr double k_tar_1500 = -33.92 + 0.4739 * 1500 - 3.017e-4 * 1500 * 1500 + 7.13e-8 * 1500 * 1500 * 1500;
constexpr double k_tar_integral_1500 = -33.92 * 1500 + 0.4739 / 2 * 1500 * 1500 - 3.017e-4 / 3 * 1500 * 1500 * 1500 +
                                       7.13e-8 / 4 * 1500 * 1500 * 1500 * 1500;

constexpr Thermo k_thermo[k_gas_species] = {
    {1000,
     {3.78245636e+00, -2.99673416e-03, 9.84730201e-06, -9.68129509e-09, 3.24372837e-12, -1.06394356e+03},
     {3.28253784e+00, 1.48308754e-03, -7.57966669e-07, 2.09470555e-10, -2.16717794e-14, -1.08845772e+03}},
    {1000,
     {2.35677352e+00, 8.98459677e-03, -7.12356269e-06, 2.45919022e-09, -1.43699548e-13, -4.83719697e+04},
     {3.85746029e+00, 4.41437026e-03, -2.21481404e-06, 5.23490188e-10, -4.72084164e-14, -4.87591660e+04}},
    {1000,
     {3.57953347e+00, -6.10353680e-04, 1.01681433e-06, 9.07005884e-10, -9.04424499e-13, -1.43440860e+04},
     {2.71518561e+00, 2.06252743e-03, -9.98825771e-07, 2.30053008e-10, -2.03647716e-14, -1.41518724e+04}},
    {1000,
     {4.19864056e+00, -2.03643410e-03, 6.52040211e-06, -5.48797062e-09, 1.77197817e-12, -3.02937267e+04},
     {3.03399249e+00, 2.17691804e-03, -1.64072518e-07, -9.70419870e-11, 1.68200992e-14, -3.00042971e+04}},
    {1000,
     {2.34433112e+00, 7.98052075e-03, -1.94781510e-05, 2.01572094e-08, -7.37611761e-12, -9.17935173e+02},
     {3.33727920e+00, -4.94024731e-05, 4.99456778e-07, -1.79566394e-10, 2.00255376e-14, -9.50158922e+02}},
    {1000,
     {5.14987613e+00, -1.36709788e-02, 4.91800599e-05, -4.84743026e-08, 1.66693956e-11, -1.02466476e+04},
     {7.48514950e-02, 1.33909467e-02, -5.73285809e-06, 1.22292535e-09, -1.01815230e-13, -9.46834459e+03}},
    {1500,
     {-33.92 / k_r, 0.4739 / k_r, -3.017e-4 / k_r, 7.13e-8 / k_r, 0, (82930 - k_tar_integral) / k_r},
     {k_tar_1500 / k_r, 0, 0, 0, 0, (82930 - k_tar_integral + k_tar_integral_1500 - k_tar_1500 * 1500) / k_r}},
    {1000,
     {3.29867700e+00, 1.40824040e-03, -3.96322200e-06, 5.64151500e-09, -2.44485400e-12, -1.02089990e+03},
     {2.92664000e+00, 1.48797680e-03, -5.68476000e-07, 1.00970380e-10, -6.75335100e-15, -9.22797700e+02}},
};

const double* of(int k, double t) {
  const Thermo& s = k_thermo[k];
  return (t < s.split ? s.low : s.high).a;
}

/// The same beyond the range with the heat capacity of its end: monotonous, so that Newton's method ends.
double bounded(double t) { return fmax2(k_coldest, fmin2(k_hottest, t)); }

}  // namespace

const SpeciesInfo& species(int k) noexcept { return k_info[k]; }

double heat_capacity(int k, double temperature) noexcept {
  const double t = bounded(temperature), *a = of(k, t);
  return (a[0] + t * (a[1] + t * (a[2] + t * (a[3] + t * a[4])))) * k_gas_constant / k_info[k].molar_mass;
}

double enthalpy(int k, double temperature) noexcept {
  const double t = bounded(temperature), *a = of(k, t);
  const double h = a[5] + t * (a[0] + t * (a[1] / 2 + t * (a[2] / 3 + t * (a[3] / 4 + t * a[4] / 5))));
  return h * k_gas_constant / k_info[k].molar_mass + heat_capacity(k, t) * (temperature - t);
}

double enthalpy(const GasFractions& y, double t) noexcept {
  double h = 0;
  for (int k = 0; k < k_gas_species; ++k)
    if (y[static_cast<std::size_t>(k)] != 0) h += y[static_cast<std::size_t>(k)] * enthalpy(k, t);
  return h;
}

double heat_capacity(const GasFractions& y, double t) noexcept {
  double c = 0;
  for (int k = 0; k < k_gas_species; ++k)
    if (y[static_cast<std::size_t>(k)] != 0) c += y[static_cast<std::size_t>(k)] * heat_capacity(k, t);
  return c;
}

double temperature_of(const GasFractions& y, double h, double guess) noexcept {
  double t = bounded(guess);
  for (int q = 0; q < 50; ++q) {
    const double step = (h - enthalpy(y, t)) / heat_capacity(y, t);
    t += step;
    if (step * step < 1e-24 * t * t) break;
  }
  return t;
}

double specific_gas_constant(const GasFractions& y) noexcept {
  double n = 0;
  for (int k = 0; k < k_gas_species; ++k) n += y[static_cast<std::size_t>(k)] / k_info[k].molar_mass;
  return n * k_gas_constant;
}

double steam_pressure(const GasFractions& y, double pressure) noexcept {
  const auto k = static_cast<std::size_t>(GasSpecies::h2o);
  return pressure * (y[k] * k_gas_constant / k_info[k].molar_mass) / specific_gas_constant(y);
}

double saturation_pressure(double t) noexcept {
  if (t > 647.1) return 1e300;
  return 610.78 * det::exp(17.269 * (t - 273.16) / (fmax2(t, k_coldest) - 35.86));
}

double viscosity(double temperature) noexcept {
  const double t = bounded(temperature);
  return 1.458e-6 * t * __builtin_sqrt(t) / (t + 110.4);
}

double conductivity(const GasFractions& y, double t) noexcept { return viscosity(t) * heat_capacity(y, t) / k_prandtl; }

}  // namespace talus::gas
