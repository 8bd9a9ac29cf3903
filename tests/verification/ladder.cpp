// Helpers of the verification ladder; see ladder.hpp.
#include "ladder.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace talus::verification {

void figure(const std::string& name, double value, const std::string& note) {
  std::printf("figure: %-72s %12.6g %s\n", name.c_str(), value, note.c_str());
  std::fflush(stdout);
}

bool full() { return std::getenv("TALUS_FULL") != nullptr; }

Line fit_line(const std::vector<double>& x, const std::vector<double>& y) {
  const auto n = static_cast<double>(x.size());
  double mx = 0, my = 0;
  for (std::size_t k = 0; k < x.size(); ++k) {
    mx += x[k] / n;
    my += y[k] / n;
  }
  double sxx = 0, sxy = 0;
  for (std::size_t k = 0; k < x.size(); ++k) {
    sxx += (x[k] - mx) * (x[k] - mx);
    sxy += (x[k] - mx) * (y[k] - my);
  }
  Line l;
  l.slope = sxy / sxx;
  l.intercept = my - l.slope * mx;
  double rest = 0;
  for (std::size_t k = 0; k < x.size(); ++k) rest += std::pow(y[k] - l.intercept - l.slope * x[k], 2);
  l.error = n > 2 ? std::sqrt(rest / (n - 2) / sxx) : 0;
  return l;
}

double density_of(double mass, double r) { return mass / sphere_mass(1, r); }

double damping_ratio(double e) { return -std::log(e) / std::sqrt(k_pi * k_pi + std::log(e) * std::log(e)); }

double gauss(std::uint64_t seed, std::uint64_t k) {
  const double u = 1 - uniform(seed, 2 * k), turn = 2 * k_pi * uniform(seed, 2 * k + 1);
  return std::sqrt(-2 * std::log(u)) * std::cos(turn);
}

double Hertz::depth(double v) const { return std::pow(5 * m * v * v / (4 * k), 0.4); }

double Hertz::contact(double v) const {
  // 2 * integral_0^1 dx / sqrt(1 - x^(5/2)) = (4/5) sqrt(pi) Gamma(2/5) / Gamma(9/10) = 2.9433
  return 0.8 * std::sqrt(k_pi) * std::tgamma(0.4) / std::tgamma(0.9) * depth(v) / v;
}

Hertz hertz_contact(const Material& a, double r_a, const Material& b, double r_b, double e) {
  const double e_star =
      1 / ((1 - a.poisson * a.poisson) / a.young + (r_b > 0 ? (1 - b.poisson * b.poisson) / b.young : 0.0));
  const double r = r_b > 0 ? r_a * r_b / (r_a + r_b) : r_a, m_a = sphere_mass(a.density, r_a);
  const double m_b = r_b > 0 ? sphere_mass(b.density, r_b) : 0;
  Hertz h;
  h.k = 4.0 / 3.0 * e_star * std::sqrt(r);
  h.alpha = -std::sqrt(5.0) * std::log(e) / std::sqrt(k_pi * k_pi + std::log(e) * std::log(e));
  h.m = r_b > 0 ? m_a * m_b / (m_a + m_b) : m_a;
  return h;
}

double repulsive_share_linear(double e) {
  // x = (v/w) exp(-z t) sin(w t) with omega_0 = 1; the force vanishes with the acceleration, where the rebound is
  // fastest: tan(w t) = -2 z w / (1 - 2 z^2) in the second quadrant
  const double z = damping_ratio(e), w = std::sqrt(1 - z * z);
  const double phase = std::atan2(2 * z * w, 1 - 2 * z * z), t = (k_pi - phase) / w;
  const double v = std::exp(-z * t) * (std::cos(w * t) - z / w * std::sin(w * t));  // velocity / impact speed
  return (1 - v) / (1 + e);
}

double repulsive_share_hertz(double e) {
  // m = k = v = 1: x'' = -x^1.5 - alpha x^0.25 x'. Steps grow as the square of the time from touch, which tames
  // x^0.25; the fastest rebound is where the force vanishes.
  const double alpha = -std::sqrt(5.0) * std::log(e) / std::sqrt(k_pi * k_pi + std::log(e) * std::log(e));
  const auto a = [alpha](double x, double v) {
    return x > 0 ? -std::pow(x, 1.5) - alpha * std::pow(x, 0.25) * v : 0.0;
  };
  double x = 0, v = 1, fastest = 0;
  const int n = 20000;
  for (int k = 0; k < n && x >= 0; ++k) {
    const double s0 = static_cast<double>(k) / n, s1 = static_cast<double>(k + 1) / n, h = 12 * (s1 * s1 - s0 * s0);
    const double a1 = a(x, v), a2 = a(x + h / 2 * v, v + h / 2 * a1), v2 = v + h / 2 * a1;
    const double a3 = a(x + h / 2 * v2, v + h / 2 * a2), v3 = v + h / 2 * a2;
    const double a4 = a(x + h * v3, v + h * a3), v4 = v + h * a3;
    x += h / 6 * (v + 2 * v2 + 2 * v3 + v4);
    v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
    fastest = std::min(fastest, v);
  }
  return (1 - fastest) / (1 + e);
}

}  // namespace talus::verification
