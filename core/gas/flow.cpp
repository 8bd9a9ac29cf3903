// See flow.hpp. Picard's iteration on the resistances, with the speed that they hold for taken half way: for a purely
// inertial resistance, which is the hard case, the plain iteration would swing about the solution for ever.
#include "core/gas/flow.hpp"

#include <fmt/format.h>

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCholesky>

#include "core/base/det_math.hpp"
#include "core/base/error.hpp"
#include "core/gas/drag.hpp"

namespace talus::gas {

namespace {

using Matrix = Eigen::SparseMatrix<double>;
using Vector = Eigen::VectorXd;

constexpr int k_direct_cells = 20000, k_direct_width = 9;  // in a thin column LDLT is the faster one
constexpr int k_most_iterations = 200;
constexpr double k_change = 1e-10;      // relative change of velocities at which the iteration ends
constexpr double k_most_change = 1e-6;  // ... that is accepted when it has not
constexpr double k_still = 1e-7;        // or a change [m/s] of gas that is nearly at rest
constexpr int k_most_turns = 4;         // of the flow through an open face
constexpr double k_cg_tolerance = 1e-13, k_cg_enough = 1e-9;  // aimed at; accepted where rounding ends it earlier

/// Lower triangle of the matrix over cells, with the places of diagonal and faces in its values.
struct System {
  Matrix a;
  std::vector<Eigen::Index> diagonal, face;
  Eigen::SimplicialLDLT<Matrix, Eigen::Lower> direct;
  Eigen::ConjugateGradient<Matrix, Eigen::Lower,
                           Eigen::IncompleteCholesky<double, Eigen::Lower, Eigen::NaturalOrdering<int>>>
      iterative;

  bool thin;

  explicit System(const Grid& g) : a(g.cells(), g.cells()) {
    const int longest = std::max({g.n[0], g.n[1], g.n[2]});
    thin = g.cells() <= k_direct_cells && g.cells() / longest <= k_direct_width;
    std::vector<Eigen::Triplet<double>> t;
    for (int c = 0; c < g.cells(); ++c) t.emplace_back(c, c, 1.0);
    for (const InnerFace& f : g.inner) t.emplace_back(std::max(f.a, f.b), std::min(f.a, f.b), 0.0);
    a.setFromTriplets(t.begin(), t.end());
    const auto place = [&](int row, int column) {
      for (auto q = a.outerIndexPtr()[column]; q < a.outerIndexPtr()[column + 1]; ++q)
        if (a.innerIndexPtr()[q] == row) return static_cast<Eigen::Index>(q);
      return Eigen::Index{-1};
    };
    for (int c = 0; c < g.cells(); ++c) diagonal.push_back(place(c, c));
    for (const InnerFace& f : g.inner) face.push_back(place(std::max(f.a, f.b), std::min(f.a, f.b)));
    if (thin) direct.analyzePattern(a);
    iterative.setTolerance(k_cg_tolerance);
  }

  void clear() { std::fill(a.valuePtr(), a.valuePtr() + a.nonZeros(), 0.0); }
  void add_diagonal(int c, double x) { a.valuePtr()[diagonal[static_cast<std::size_t>(c)]] += x; }
  void add_face(const InnerFace& f, std::size_t k, double x) {
    a.valuePtr()[face[k]] -= x;
    add_diagonal(f.a, x);
    add_diagonal(f.b, x);
  }
  bool solve(const Vector& b, Vector& x) {
    if (thin) {
      direct.factorize(a);
      if (direct.info() != Eigen::Success) return false;
      x = direct.solve(b);
      return true;
    }
    iterative.compute(a);
    x = iterative.solveWithGuess(b, x).eval();
    return iterative.info() == Eigen::Success || iterative.error() < k_cg_enough;
  }
};

/// Resistances of a cell, and the density that they were made with.
struct Resistance {
  double bed = 0, empty = 0, rho = 0;
};

}  // namespace

struct FlowSolver::Impl {
  const Grid grid;
  System system;
  Vector b, x;
  std::vector<Resistance> resistance;
  std::vector<double> slip, speed;  ///< of cells, half way between the last two iterations
  std::vector<double> outer_rho;    ///< of outer faces that are open to a pressure
  std::vector<double> outside;      ///< pressure before them [Pa]
  std::vector<int> turns;           ///< how often the flow through an outer face has turned since the first iteration

  explicit Impl(const Grid& g) : grid(g), system(g), b(g.cells()), x(g.cells()) {
    resistance.resize(static_cast<std::size_t>(g.cells()));
    outer_rho.resize(g.outer.size());
    outside.resize(g.outer.size());
    turns.resize(g.outer.size());
  }

  /// Outside an opening its gas is at rest: the given pressure at the lowest point of the grid, less its weight above.
  void set_outside(const FlowInput& in) {
    Vec3 low = grid.lower;
    for (int k = 0; k < 3; ++k)
      if (in.gravity[k] > 0) low[k] = grid.upper[k];
    for (std::size_t k = 0; k < outside.size(); ++k)
      if (const Opening& o = in.outer[k]; o.kind == Opening::Kind::pressure)
        outside[k] = o.pressure * det::exp(dot(in.gravity, grid.outer[k].middle - low) / o.gas_constant_t);
  }

  Vec3 moved(const FlowInput& in, std::size_t c) const { return in.porosity[c] * in.solid_velocity[c]; }

  /// Velocities of cells: means of their faces. Along a periodic axis of one cell, which has no face and no difference
  /// of pressure, the gas goes with its grains.
  void cell_velocities(const FlowInput& in, Flow& flow) const {
    flow.velocity.assign(static_cast<std::size_t>(grid.cells()), Vec3{});
    for (std::size_t k = 0; k < grid.inner.size(); ++k) {
      const InnerFace& f = grid.inner[k];
      flow.velocity[static_cast<std::size_t>(f.a)][f.axis] += 0.5 * flow.inner[k];
      flow.velocity[static_cast<std::size_t>(f.b)][f.axis] += 0.5 * flow.inner[k];
    }
    for (std::size_t k = 0; k < grid.outer.size(); ++k) {
      const OuterFace& f = grid.outer[k];
      flow.velocity[static_cast<std::size_t>(f.cell)][f.axis] += (f.high ? 0.5 : -0.5) * flow.outer[k];
    }
    for (int axis = 0; axis < 3; ++axis)
      if (const auto a = static_cast<std::size_t>(axis); grid.periodic[a] && grid.n[a] == 1)
        for (std::size_t c = 0; c < flow.velocity.size(); ++c) flow.velocity[c][axis] = moved(in, c)[axis];
  }

  void set_resistances(const FlowInput& in, const Flow& flow) {
    const auto n = static_cast<std::size_t>(grid.cells());
    const bool first = flow.iterations == 1;
    if (first) slip.assign(n, 0), speed.assign(n, 0), std::fill(turns.begin(), turns.end(), 0);
    const double w = flow.iterations < 30 ? 0.5 : flow.iterations < 100 ? 0.2 : 0.05;  // of the present velocity
    for (std::size_t c = 0; c < n; ++c) {
      const double now = norm(flow.velocity[c] - moved(in, c)), whole = norm(flow.velocity[c]);
      slip[c] = first ? now : (1 - w) * slip[c] + w * now;
      speed[c] = first ? whole : (1 - w) * speed[c] + w * whole;
      const double rho = flow.pressure[c] / in.gas_constant_t[c], mu = in.viscosity[c], e = in.porosity[c];
      Resistance& r = resistance[c];
      r = {0, 0, rho};
      if (in.diameter[c] > 0 && e < 1)
        r.bed = in.drag_factor[c] * bed_resistance(in.drag, e, in.diameter[c], mu, rho, slip[c]);
      if (e > in.most_porosity)
        r.empty = fmax2(0, bed_resistance(in.drag, in.most_porosity, in.mean_diameter, mu, rho, speed[c]) - r.bed);
    }
  }

  /// A face between two cells: U = (-(p_b - p_a) / h + push) / r.
  struct FaceLaw {
    double r, push, rho;
  };
  FaceLaw law_of(const FlowInput& in, const InnerFace& f) const {
    const auto a = static_cast<std::size_t>(f.a), b = static_cast<std::size_t>(f.b);
    const Resistance &ra = resistance[a], &rb = resistance[b];
    const double rho = 0.5 * (ra.rho + rb.rho);
    const double drive = 0.5 * (ra.bed * moved(in, a)[f.axis] + rb.bed * moved(in, b)[f.axis]);
    return {0.5 * ((ra.bed + ra.empty) + (rb.bed + rb.empty)), drive + rho * in.gravity[f.axis], rho};
  }
  /// An open face, half a cell from its middle: outward U = ((p - p_out) / (h/2) + push) / r. The gas has the density
  /// of the side that it comes from. Where light gas within and heavy gas without would each drive it the other way, it
  /// turns in every iteration: then that of both sides.
  FaceLaw law_of(const FlowInput& in, const Flow& flow, const OuterFace& f, std::size_t k) const {
    const auto c = static_cast<std::size_t>(f.cell);
    const double sign = f.high ? 1 : -1;
    const double mean = 0.5 * (flow.pressure[c] + outside[k]);
    const double within = in.gas_constant_t[c], without = in.outer[k].gas_constant_t;
    const double rho = mean / (turns[k] >= k_most_turns ? 0.5 * (within + without)
                               : flow.outer[k] < 0      ? without
                                                        : within);
    return {resistance[c].bed + resistance[c].empty,
            sign * (resistance[c].bed * moved(in, c)[f.axis] + rho * in.gravity[f.axis]), rho};
  }

  /// Of pressures less the reference.
  void assemble(const FlowInput& in, const Flow& flow) {
    system.clear();
    for (int q = 0; q < grid.cells(); ++q) {
      const auto c = static_cast<std::size_t>(q);
      const double store = in.porosity[c] * grid.volume / (in.gas_constant_t[c] * in.dt);
      system.add_diagonal(q, store);
      b[q] = in.mass[c] / in.dt - store * in.reference + in.source[c];
    }
    for (std::size_t k = 0; k < grid.inner.size(); ++k) {
      const InnerFace& f = grid.inner[k];
      const FaceLaw l = law_of(in, f);
      const double g = l.rho * grid.area[static_cast<std::size_t>(f.axis)] / l.r;
      system.add_face(f, k, g / grid.h[f.axis]);
      b[f.a] -= g * l.push;
      b[f.b] += g * l.push;
    }
    for (std::size_t k = 0; k < grid.outer.size(); ++k) {
      const OuterFace& f = grid.outer[k];
      const Opening& o = in.outer[k];
      if (o.kind == Opening::Kind::flow) b[f.cell] += o.flux;
      if (o.kind != Opening::Kind::pressure) continue;
      const FaceLaw l = law_of(in, flow, f, k);
      const double g = l.rho * grid.area[static_cast<std::size_t>(f.axis)] / l.r, to = g / (0.5 * grid.h[f.axis]);
      system.add_diagonal(f.cell, to);
      b[f.cell] += to * (outside[k] - in.reference) - g * l.push;
    }
  }

  /// Velocities and fluxes of the solved pressures, with the laws that the system was made of.
  void take_velocities(const FlowInput& in, const Flow& before, Flow& flow) {
    const auto p = [&](int c) { return x[c]; };
    for (std::size_t k = 0; k < grid.inner.size(); ++k) {
      const InnerFace& f = grid.inner[k];
      const FaceLaw l = law_of(in, f);
      flow.inner[k] = ((p(f.a) - p(f.b)) / grid.h[f.axis] + l.push) / l.r;
      flow.inner_flux[k] = l.rho * flow.inner[k] * grid.area[static_cast<std::size_t>(f.axis)];
    }
    for (std::size_t k = 0; k < grid.outer.size(); ++k) {
      const OuterFace& f = grid.outer[k];
      const Opening& o = in.outer[k];
      const double area = grid.area[static_cast<std::size_t>(f.axis)];
      if (o.kind == Opening::Kind::closed) {
        flow.outer[k] = flow.outer_flux[k] = 0;
      } else if (o.kind == Opening::Kind::flow) {
        const double rho = o.flux >= 0 ? before.pressure[static_cast<std::size_t>(f.cell)] / o.gas_constant_t
                                       : resistance[static_cast<std::size_t>(f.cell)].rho;
        flow.outer_flux[k] = -o.flux;
        flow.outer[k] = -o.flux / (rho * area);
      } else {
        const FaceLaw l = law_of(in, before, f, k);
        flow.outer[k] = ((p(f.cell) + in.reference - outside[k]) / (0.5 * grid.h[f.axis]) + l.push) / l.r;
        if (flow.iterations > 1 && (flow.outer[k] < 0) != (before.outer[k] < 0)) ++turns[k];
        flow.outer_flux[k] = l.rho * flow.outer[k] * area;
        outer_rho[k] = l.rho;
      }
    }
  }

  static double largest(const Flow& flow) {
    double most = 0;
    for (const auto* u : {&flow.inner, &flow.outer})
      for (const double x : *u) most = fmax2(most, __builtin_fabs(x));
    return most;
  }

  static double change_of(const Flow& a, const Flow& b) {
    double most = 1e-30, change = 0;
    const auto look = [&](const std::vector<double>& u, const std::vector<double>& w) {
      for (std::size_t k = 0; k < u.size(); ++k) {
        most = fmax2(most, __builtin_fabs(w[k]));
        change = fmax2(change, __builtin_fabs(u[k] - w[k]));
      }
    };
    look(a.inner, b.inner);
    look(a.outer, b.outer);
    return change <= 1e-14 ? 0 : change / most;
  }

  /// Pressure gradients of cells by their own law, from its halves that belong to the two faces of an axis: what a cell
  /// takes from the gas is what its grains get. The resistance of empty cells holds the gas as walls would: no grain
  /// feels it. With it half slopes sum to the differences of pressure that were solved for.
  void set_gradients(const FlowInput& in, Flow& flow) const {
    flow.gradient.assign(static_cast<std::size_t>(grid.cells()), Vec3{});
    flow.outer_pressure.resize(grid.outer.size());
    const auto half = [&](int cell, int axis, double u, double rho) {
      const auto c = static_cast<std::size_t>(cell);
      const Resistance& r = resistance[c];
      const double slope = rho * in.gravity[axis] - r.bed * (u - moved(in, c)[axis]);
      flow.gradient[c][axis] += 0.5 * slope;
      return slope - r.empty * u;
    };
    for (std::size_t k = 0; k < grid.inner.size(); ++k) {
      const InnerFace& f = grid.inner[k];
      half(f.a, f.axis, flow.inner[k], resistance[static_cast<std::size_t>(f.a)].rho);
      half(f.b, f.axis, flow.inner[k], resistance[static_cast<std::size_t>(f.b)].rho);
    }
    for (std::size_t k = 0; k < grid.outer.size(); ++k) {
      const OuterFace& f = grid.outer[k];
      const double sign = f.high ? 1 : -1;
      const double rho =
          in.outer[k].kind == Opening::Kind::pressure ? outer_rho[k] : resistance[static_cast<std::size_t>(f.cell)].rho;
      const double slope = half(f.cell, f.axis, sign * flow.outer[k], rho);
      flow.outer_pressure[k] = flow.pressure[static_cast<std::size_t>(f.cell)] + sign * 0.5 * grid.h[f.axis] * slope;
    }
    flow.resistance.resize(resistance.size());
    for (std::size_t c = 0; c < resistance.size(); ++c) flow.resistance[c] = resistance[c].bed;
  }
};

FlowSolver::FlowSolver(const Grid& grid) : impl_(std::make_unique<Impl>(grid)) {}
FlowSolver::~FlowSolver() = default;
FlowSolver::FlowSolver(FlowSolver&&) noexcept = default;

void FlowSolver::solve(const FlowInput& in, Flow& flow) {
  Impl& m = *impl_;
  flow.inner.resize(m.grid.inner.size());
  flow.outer.resize(m.grid.outer.size());
  flow.inner_flux.resize(flow.inner.size());
  flow.outer_flux.resize(flow.outer.size());
  m.set_outside(in);
  for (int c = 0; c < m.grid.cells(); ++c) m.x[c] = flow.pressure[static_cast<std::size_t>(c)] - in.reference;
  for (flow.iterations = 1; flow.iterations <= k_most_iterations; ++flow.iterations) {
    m.cell_velocities(in, flow);
    m.set_resistances(in, flow);
    m.assemble(in, flow);
    if (!m.system.solve(m.b, m.x) || !m.x.allFinite())
      throw Error(ErrorCode::physics, "the pressure of the gas cannot be solved for", "gas", "a smaller gas.every");
    const Flow before = flow;
    m.take_velocities(in, before, flow);
    for (int c = 0; c < m.grid.cells(); ++c) {
      const double p = m.x[c] + in.reference;
      if (!(p > 0))
        throw Error(ErrorCode::physics, "the pressure of the gas falls to zero", "gas",
                    "less flow, or a coarser bed; where no inlet has kind = \"pressure\" no more may leave than comes");
      flow.pressure[static_cast<std::size_t>(c)] = p;
    }
    flow.change = Impl::change_of(before, flow);
    if (flow.change <= k_change && flow.iterations > 1) break;
  }
  if (!(flow.change <= k_most_change) && !(flow.change * Impl::largest(flow) <= k_still))
    throw Error(
        ErrorCode::physics,
        fmt::format("the flow of the gas does not settle: velocities change by {:.2g} per iteration", flow.change),
        "gas", "larger cells or a smaller gas.most_porosity");
  m.cell_velocities(in, flow);
  m.set_gradients(in, flow);
}

}  // namespace talus::gas
