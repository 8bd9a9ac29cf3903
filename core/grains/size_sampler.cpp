// Sieve classes are inverted in closed form; normal and log-normal densities are tabulated on 2048 cells, linear within
// a cell: the error of the cumulative fraction is below 1e-6, and no rejection loop makes a draw depend on another one.
#include "core/grains/size_sampler.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/det_math.hpp"

namespace talus {

SizeSampler::SizeSampler(const SizeDistribution& size) {
  using Kind = SizeDistribution::Kind;
  inverse_square_ = size.by_mass && (size.kind == Kind::sieve || size.kind == Kind::uniform);
  if (size.kind == Kind::sieve) {
    for (std::size_t i = 0; i < size.weights.size(); ++i)
      add_class(size.edges[i], size.edges[i + 1], size.weights[i], size.by_mass);
  } else if (size.kind == Kind::constant || !(size.smallest() < size.largest())) {
    inverse_square_ = false;
    add_class(size.smallest(), size.smallest(), 1, false);
  } else if (size.kind == Kind::uniform) {
    add_class(size.min, size.max, 1, size.by_mass);
  } else {
    add_density(size);
  }
  normalise();
}

void SizeSampler::add_class(double a, double b, double weight, bool by_mass) {
  if (!(weight > 0)) return;
  // Mass uniform in d on [a, b]: number = weight / (b - a) * integral of d^-3.
  const double number = by_mass ? weight / (b - a) * 0.5 * (1 / (a * a) - 1 / (b * b)) : weight;
  pieces_.push_back({a, b, 0, number, 1, 1});
}

void SizeSampler::add_density(const SizeDistribution& size) {
  constexpr int cells = 2048;
  const bool lognormal = size.kind == SizeDistribution::Kind::lognormal;
  const double ratio = size.stddev / size.mean;
  const double sigma = lognormal ? std::sqrt(det::log(1 + ratio * ratio)) : size.stddev;
  const double mu = lognormal ? det::log(size.mean) - 0.5 * sigma * sigma : size.mean;
  // Beyond 9 sigma nothing is drawn; a narrow peak in a wide range keeps its resolution. By mass the number density of
  // a log-normal peaks 3 sigma^2 lower on the log scale.
  const double shift = lognormal && size.by_mass ? 3 * sigma * sigma : 0;
  double low = mu - shift - 9 * sigma, high = mu + 9 * sigma;
  if (lognormal) low = det::exp(low), high = det::exp(high);
  low = fmax2(low, size.min);
  high = fmin2(high, size.max);
  if (!(low < high)) low = size.min, high = size.max;

  std::vector<double> d(cells + 1), exponent(cells + 1);
  double largest = -k_never;
  for (int k = 0; k <= cells; ++k) {
    d[k] = k == cells ? high : low + (high - low) * (static_cast<double>(k) / cells);
    const double z = ((lognormal ? det::log(d[k]) : d[k]) - mu) / sigma;
    exponent[k] = -0.5 * z * z;
    if (lognormal) exponent[k] = exponent[k] - det::log(d[k]);
    if (size.by_mass) exponent[k] = exponent[k] - 3 * det::log(d[k]);
    largest = fmax2(largest, exponent[k]);
  }
  for (int k = 0; k < cells; ++k) {
    const double p = det::exp(exponent[k] - largest), q = det::exp(exponent[k + 1] - largest);
    if (p + q > 0) pieces_.push_back({d[k], d[k + 1], 0, 0.5 * (p + q) * (d[k + 1] - d[k]), p, q});
  }
}

void SizeSampler::normalise() noexcept {
  double sum = 0;
  for (Piece& piece : pieces_) {
    piece.low = sum;
    sum += piece.high;
    piece.high = sum;
  }
  for (Piece& piece : pieces_) piece.low = piece.low / sum, piece.high = piece.high / sum;
}

double SizeSampler::diameter(double u) const noexcept {
  auto it = std::lower_bound(pieces_.begin(), pieces_.end(), u, [](const Piece& p, double x) { return p.high <= x; });
  if (it == pieces_.end()) --it;
  const Piece& piece = *it;
  double t = (u - piece.low) / (piece.high - piece.low);  // fraction of the piece's number
  t = fmin2(fmax2(t, 0), 1);
  double d;
  if (inverse_square_) {
    const double ia = 1 / (piece.a * piece.a), ib = 1 / (piece.b * piece.b);
    d = 1 / std::sqrt(ia - t * (ia - ib));
  } else {
    // Linear density p -> q: solve p s + (q - p) s^2 / 2 = t (p + q) / 2 for s in [0, 1], in the form without
    // cancellation.
    const double area = t * (piece.p + piece.q);
    const double root = std::sqrt(piece.p * piece.p + (piece.q - piece.p) * area);
    const double s = area > 0 ? area / (piece.p + root) : 0;
    d = piece.a + s * (piece.b - piece.a);
  }
  return fmin2(fmax2(d, piece.a), piece.b);
}

}  // namespace talus
