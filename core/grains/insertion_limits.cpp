// What a source can never deliver, said before anything is drawn or allocated. Who calls it: core/grains/insertion.cpp
// (construction). Invariant: only what is plain from volumes is refused here; whether a pack fits is known when it has
// been placed.
#include <fmt/format.h>

#include "core/base/count.hpp"
#include "core/base/det_math.hpp"
#include "core/base/error.hpp"
#include "core/base/memory.hpp"
#include "core/grains/body.hpp"
#include "core/grains/insertion.hpp"
#include "core/grains/region.hpp"

namespace talus {
namespace {

constexpr double k_densest = 0.7405;     ///< solid fraction of the closest packing of equal spheres
constexpr double k_random = 0.38;        ///< where random sequential packing of equal spheres ends
constexpr double k_wide = 0.5;           ///< what similar spheres placed at random stay below, far from all sides
constexpr double k_many = 1000;          ///< fewer spheres may fill a region that was made for them more densely
constexpr double k_most = 1 << 30;       ///< rows of the engine
constexpr double k_bytes_present = 600;  ///< [B] per particle: rows, contacts, lists, and the source's own at the start

double sphere(double d) { return Body{0.5 * d}.volume(); }

/// Mean volume of the particles that a source draws [m3].
double mean_volume(const SizeSampler& sampler) {
  constexpr int n = 1024;
  double sum = 0;
  for (int i = 0; i < n; ++i) sum += sphere(sampler.diameter((i + 0.5) / n)) / n;
  return sum;
}

/// Solid fraction that n particles of the source surely cannot exceed when they are placed at random.
double densest(const Source& s, double n) {
  if (n < k_many) return 1;
  const double largest = s.size.largest();
  bool wide = s.region.shape != Region::Shape::mesh && n >= 10 * k_many && s.size.smallest() >= 0.5 * largest;
  for (int k = 0; k < 3; ++k) wide = wide && s.region.upper[k] - s.region.lower[k] >= 5 * largest;
  return wide ? k_wide : k_densest;
}

/// 12345 as it is, 1.2e+09 from a million on: estimates have no more digits.
std::string count_text(double n) { return n < 1e6 ? fmt::format("{:.0f}", n) : fmt::format("{:.3g}", n); }

/// Sites of the lattice in the bounds of its region, at most.
double lattice_sites(const Domain& d, const Source& s) {
  const double largest = s.size.largest(), pitch = s.spacing * largest;
  const bool hexagonal = s.lattice == Source::Lattice::hexagonal;
  const double step[3] = {pitch, (hexagonal ? 0.8660254037844386 : 1) * pitch,
                          (hexagonal ? 0.816496580927726 : 1) * pitch};
  double sites = 1;
  for (int k = 0; k < 3; ++k) {
    const double room = s.region.upper[k] - s.region.lower[k] - (spans(d, s.region, k) ? 0.5 : 1) * largest;
    sites *= static_cast<double>(count_floor(room / step[k] * (1 + 1e-12) + 1e-9)) + 1;
  }
  return sites;
}

}  // namespace

void Insertion::check_region(std::size_t s) const {
  const Source& source = scene_.sources[s];
  const Region& g = source.region;
  const double largest = source.size.largest() * largest_share(scene_, s);
  const auto refuse = [&](const std::string& what, const std::string& cure) {
    throw Error(ErrorCode::scene, what, fmt::format("source '{}'", source.name), cure);
  };
  if (!(source.size.smallest() > 0)) refuse("the smallest diameter is not positive", "diameters must be > 0");
  if (const auto fault = region_fault(scene_.domain, g, true)) refuse(fault->text, "move or shorten the region");
  const char* const whole = "spheres must fit into the region as a whole";
  for (int k = 0; k < 3; ++k) {
    const double room = g.upper[k] - g.lower[k];
    if (!spans(scene_.domain, g, k) && room < largest)
      refuse(fmt::format("the region is {:g} m wide, the largest particle {:g} m: {:.3g} m too little", room, largest,
                         largest - room),
             whole);
  }
  if (g.radius > 0 && 2 * g.radius < largest)
    refuse(g.shape == Region::Shape::sphere ? "the sphere is smaller than the largest particle"
                                            : "the cylinder is narrower than the largest particle",
           whole);
  bool closed = false;
  for (int k = 0; k < 3; ++k) closed = closed || spans(scene_.domain, g, k);
  if (g.shape == Region::Shape::cylinder && !closed && g.length < largest)
    refuse("the cylinder is shorter than the largest particle", whole);
}

/// Particles that a pack will hold, at most; 0 for streams. Error{scene} for what can never fit.
double Insertion::check_numbers(std::size_t s) const {
  const Source& source = scene_.sources[s];
  const double each = mean_volume(samplers_[s]), room = volume(source.region);
  const Material& material = scene_.materials[static_cast<std::size_t>(source.material)];
  const double density = shape_of(s) != nullptr ? shape_of(s)->density_of(material) : material.density;
  const auto refuse = [&](const std::string& asked, const std::string& fits) {
    throw Error(ErrorCode::scene, fmt::format("{}, {}", asked, fits), fmt::format("source '{}'", source.name),
                "ask for fewer, or enlarge the region");
  };
  const std::string at_random =
      fmt::format("about {} fit into the region at random", count_text(k_random * room / each));
  double wanted = k_never;
  if (source.number > 0) wanted = static_cast<double>(source.number);
  if (source.mass > 0) wanted = fmin2(wanted, source.mass / density / each);
  const std::string asked =
      source.number > 0 && wanted == static_cast<double>(source.number)
          ? fmt::format("{} particles are asked for", source.number)
          : fmt::format("{:g} kg are asked for, about {} particles", source.mass, count_text(wanted));
  const auto too_many = [&](double n) { return n * each > densest(source, n) * room; };
  if (source.kind == Source::Kind::lattice) {
    const double sites =
        fmin2(lattice_sites(scene_.domain, source), fmax2(k_many, 1.5 * room / sphere(source.size.largest())));
    // sizes drawn for a mass scatter about their mean
    if (wanted < k_never && wanted > (source.mass > 0 ? 1.2 * sites + 10 : sites))
      refuse(asked, fmt::format("at most {} fit on this lattice", count_text(sites)));
    return fmin2(wanted, sites);
  }
  if (source.kind == Source::Kind::random) {
    if (too_many(wanted)) refuse(asked, at_random);
    return wanted;
  }
  const double rate = source.number_rate > 0 ? source.number_rate : source.mass_rate / density / each;
  const double due = fmin2(wanted, rate * source.interval);
  if (too_many(due)) refuse(fmt::format("{} particles are due in every interval", count_text(due)), at_random);
  return 0;
}

void Insertion::check_memory() const {
  double total = 0, most = 0;
  std::size_t greatest = 0;
  for (std::size_t s = 0; s < scene_.sources.size(); ++s) {
    const double n =
        scene_.sources[s].kind == Source::Kind::file
            ? static_cast<double>(files_[s].size()) * static_cast<double>(tiles(s))
            : check_numbers(s) * (shape_of(s) != nullptr ? static_cast<double>(shape_of(s)->spheres.size()) : 1);
    total += n;
    if (n > most) most = n, greatest = s;
  }
  if (total == 0) return;
  const std::string where = fmt::format("source '{}'", scene_.sources[greatest].name);
  if (total > k_most)
    throw Error(ErrorCode::scene,
                fmt::format("{} particles, at most 2^30 = {:.0f} are possible", count_text(total), k_most), where,
                "ask for fewer");
  require_memory(total * k_bytes_present, fmt::format("a start with {} particles", count_text(total)), where,
                 "ask for fewer, or take a larger machine");
}

}  // namespace talus
