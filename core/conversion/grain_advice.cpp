// See grain_advice.hpp. Limits are those of the initial grain.
#include "core/conversion/grain_advice.hpp"

#include <fmt/format.h>

namespace talus::conversion {

GrainAdvice advise(const GrainJob& job) {
  GrainAdvice a;
  const double T0 = job.temperature;
  const Surroundings<double> s = job.around.at(0, job.form.radius, T0);
  const double Tw = s.wall_temperature, e = s.emissivity * job.matter.emissivity[0];
  a.film = s.film + e * heat::k_stefan * (T0 * T0 + Tw * Tw) * (T0 + Tw);
  const double k = most(job.matter.conductivity_wet.at(T0), job.matter.least_conductivity), R = job.form.radius;
  a.biot = a.film * R / (3 * k);
  double c = 0;
  for (const Solid& x : job.matter.solids)
    c += x.initial * job.matter.heat_capacity[static_cast<std::size_t>(x.kind)].at(T0);
  const double diffusivity = k / (job.matter.density * c);
  a.diffusion = R * R / diffusivity;
  // TR-BDF2 damps without a change of sign up to 2.41 / eigenvalue; the largest eigenvalue is below 4 D / dx^2.
  const double dx = R / static_cast<double>(job.form.shells);
  a.monotone = 2.41 * dx * dx / (4 * diffusivity);
  a.lumped_error = a.biot * 3 / 5;  // first term of Bi R / (5 k) against the exact slowest rate of a sphere
  return a;
}

std::string advice_text(const GrainJob& job) {
  const GrainAdvice a = advise(job);
  std::string s = fmt::format("film coefficient at the start, radiation included: {:.4g} W/m2/K\n", a.film);
  s += fmt::format(
      "Biot number h R / (3 k): {:.4g}: {}\n", a.biot,
      a.biot < 0.1 ? "one temperature (level = lumped) is enough for the heat" : "gradients matter (level = shells)");
  s += fmt::format("time of conduction R^2 / diffusivity: {:.4g} s\n", a.diffusion);
  s += fmt::format("heat step: {:g} s; tr_bdf2 keeps profiles monotone up to {:.4g} s, euler always\n", job.step,
                   a.monotone);
  const double wanted = a.diffusion / 400;
  s += fmt::format("for errors below 1 % of a temperature step: at most {:.3g} s, at least {} shells\n", wanted,
                   a.biot < 0.1 ? 2
                   : a.biot < 3 ? 10
                                : 20);
  return s;
}

}  // namespace talus::conversion
