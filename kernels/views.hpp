// Plain-data arguments of the kernels. No std containers and no inline functions: these structs cross translation
// units compiled for different instruction sets.
#pragma once

#include <cstdint>

#include "core/rules/pair_parameters.hpp"

namespace talus {

inline constexpr int k_block = 128;        ///< contacts per L1 block (DESIGN 2.4)
inline constexpr int k_pad = 16;           ///< slack behind every per-contact array
inline constexpr int k_max_history = 8;    ///< history columns of the widest law
inline constexpr int k_usual_history = 5;  ///< of the laws without partial slip
inline constexpr int k_max_moment = 5;     ///< history columns of rolling and twisting, behind those of the law
inline constexpr int k_max_shaped = 6;     ///< history columns of superquadrics, in the place of those of moments
inline constexpr int k_max_columns = k_max_history + k_max_shaped;
static_assert(k_max_moment <= k_max_shaped);

/// Contacts from `to` on, up to the next run, have their history of the last step at `from` and after; -1: they are
/// new.
struct HistoryRun {
  std::int32_t to, from;
};

/// Narrow phase of one chunk: candidate pairs -> compact contacts, and where each finds its history of the last step.
struct NarrowArgs {
  const double* p;            ///< position rows {x, y, z, r} [m], 4 doubles each; row `dead` is far away with r = 0
  const std::int32_t* pi;     ///< [candidates] own row
  const std::int32_t* pj;     ///< [candidates] partner row
  std::uint8_t* mask;         ///< [candidates / 8] bit: touched at the previous step; replaced by the present one
  std::int64_t end[3];        ///< slot ends of the sections lower, interior, higher; multiples of 8
  double half[3], period[3];  ///< periodic minimum image: half period (1e300 where not periodic) and period (0)
  int periodic;               ///< any axis periodic
  HistoryRun* runs;           ///< [contacts + 2], or null: no history
  // results
  std::int32_t *ci, *cj;        ///< [contacts + pad]
  std::int64_t contact_end[3];  ///< contact ends of the three sections
  int run_count;                ///< 0: every contact has its place of the last step
};

/// Contacts that begin or end, taken out of blocks: copies of their input, then their output, laid out as in Block. They
/// are added behind all others of a chunk, in list order.
struct LateContacts {
  int n;
  std::int32_t at[k_block];  ///< place in the block, or in the chunk
  /// Input by contact: x, g, r, h as in Block. Written one at a time between other work, it lies together: as columns
  /// each contact would touch twenty cache lines.
  alignas(64) double in[k_block][24];
  alignas(64) double x[4][k_block + k_pad], g[4][k_block + k_pad], r[8][k_block + k_pad], e[3][k_block + k_pad],
      t[3][k_block + k_pad], h[4][k_block + k_pad], slid[k_block + k_pad];
  alignas(64) std::int32_t pair[k_block + k_pad];
  LateContacts* next;  ///< where the list goes on when this one is full
};

/// One block of up to k_block contacts in L1: relative geometry and motion in, force and torque rows out.
struct Block {
  int n;                               ///< contacts; arrays are padded with harmless values to a multiple of 8
  const double *x, *y, *z, *w;         ///< centre difference [m], sum of radii [m]
  const double (*g)[k_block + k_pad];  ///< distance d [m], 1/d [1/m], effective mass [kg], lever d/w [-]
  double (*r)[k_block + k_pad];  ///< in: 0..2 v_i - v_j [m/s], 4..6 r_i w_i + r_j w_j [m/s], 7 1/m_i + 1/m_j [1/kg]
                                 ///< (without rotation: 3 holds 1/m_i + 1/m_j); out: 0..2 force on i [N], 3 stiffness
                                 ///< [N/m] for the stability bound, 4..6 torque / radius [N], 7 what presses the
                                 ///< surfaces together in Coulomb's sense [N]
  const double* h_in[k_max_history];  ///< history columns of the last step
  double* h[k_max_history];           ///< of the present one; may be the same columns
  const double* reff;                 ///< R* [m] where the law wants it
  const std::int32_t* pair;           ///< material pair index where there are several materials
  double (*e)[k_block + k_pad];       ///< energy terms out: elastic [J], damping loss, friction loss of this step [J]
  /// Out of a trial (KernelTable::trial): 0 Coulomb limit [N], 1 b [m] and 2 rho [-] of CoulombLimit; r
  /// holds 0..2 trial tangential force [N], 3 stiffness, 4..6 normal, 7 normal force [N].
  double (*t)[k_block + k_pad];
  double* slid;  ///< out, or null: how long the contact has moved in this step, less than dt where it has begun [s]
  /// Where the linear law leaves contacts that begin or end, or null: then they stay in the block. Their force rows in
  /// the block are zero; a trial leaves them unfinished (KernelTable::late). Holds at most k_block more.
  LateContacts* late;
  std::int32_t first;  ///< place of the block's first contact in the chunk; for late only
};

/// Coefficients of one material pair for what is added to a law; see kernels/models/moments.hpp and cohesion.hpp.
struct AddOnParameters {
  double rolling = 0, viscous = 0;   ///< mu_r [-], eta_r [-]
  double twisting = 0, torsion = 0;  ///< mu_t [-], eta_t [-]
  double cohesion = 0;               ///< SJKR: energy density [J/m3]
};

struct LawArgs {
  PairParameters one;           ///< used where there is a single material pair
  const PairParameters* table;  ///< several materials: [pair index]
  double dt;                    ///< [s]
  int by_restitution;           ///< linear: damping follows restitution
  int centred;                  ///< dashpot: velocity at n, not that of n-1/2
  int recall;                   ///< centred: the last history column is the velocity predicted for the pair alone
  int onset, synchronised, contact_lever;
  int clip;      ///< the normal force never pulls
  int balanced;  ///< linear: the spring of a sliding contact takes the scaled force less the dashpot
  int total;     ///< Coulomb's limit counts the dashpot's share of the normal force too, where it does not pull
  int start;     ///< first step of a run: what touches has not slid yet
};

struct GatherArgs {
  const double* v;               ///< velocity rows (8 or 4 doubles)
  const double* p;               ///< position rows, for R*
  const std::uint8_t* material;  ///< or null
  int materials;
  const std::int32_t *i, *j;  ///< [n + pad] rows of the block's contacts
  int n;
  double (*x)[k_block + k_pad];  ///< out: 0..2 centre difference i - j (minimum image), 3 r_i + r_j [m]
  double (*r)[k_block + k_pad];  ///< out: relative velocity rows, see Block::r
  int periodic;
  double half[3], period[3];            ///< as in NarrowArgs
  const std::int32_t *next_i, *next_j;  ///< rows of the next block, prefetched; next_n of them; next_i may be null
  int next_n;
  const double* next_h[k_max_history];  ///< history of the next block, prefetched; next_columns of them
  int next_columns;
  double (*g)[k_block + k_pad];  ///< out: geometry, see Block::g
  double deep;                   ///< a contact with d < deep * (r_i + r_j) ...
  int deep_found;                ///< ... sets this
  double* reff;                  ///< or null
  std::int32_t* pair;            ///< or null
};

/// Geometry of contacts that do not come from a pair list (walls).
struct GeometryArgs {
  int n;
  const double *x, *y, *z, *w, *ms;  ///< centre difference [m], sum of radii [m], sum of inverse masses [1/kg]
  double (*g)[k_block + k_pad];      ///< out: see Block::g
};

struct ScatterArgs {
  double* f;  ///< force rows, indexed by absolute row
  const std::int32_t *i, *j;
  int n;
  int both_from, both_to;  ///< contacts of the block in [from, to) also act on j
  double (*r)[k_block + k_pad];
};

/// Scatter of a trial: limits the tangential force, corrects the spring of sliding contacts, then adds as ScatterArgs.
struct LimitArgs {
  ScatterArgs to;
  double (*t)[k_block + k_pad];  ///< see Block::t
  const double* lever;           ///< Block::g[3], or null: levers are the radii
  double* h[3];                  ///< tangential spring [m]
  double back;                   ///< spring per trial force [m/N]
};

/// Relative spin of a block's contacts, for laws with rolling or twisting.
struct SpinArgs {
  const double *p, *v;        ///< position rows, velocity rows of 8
  const std::int32_t *i, *j;  ///< [n] rows
  int n;
  double (*s)[k_block + k_pad];  ///< out: 0..2 w_i - w_j [rad/s], 3 the sum of 1 / (7/5 m r^2) [1/(kg m2)]
};

/// Rolling and twisting of one block: after the law, before the scatter.
struct MomentBlock {
  int n;
  const double *x, *y, *z;             ///< centre difference i - j [m]
  const double (*r)[k_block + k_pad];  ///< 3 stiffness [N/m], 7 pressing force [N], as the law leaves them
  const double* reff;                  ///< R* [m]
  const double* slid;                  ///< Block::slid [s]
  const std::int32_t* pair;            ///< material pair index where there are several materials
  double (*s)[k_block + k_pad];        ///< in: SpinArgs::s; out: 0..2 moment on i [N m], 3 zero
  double* h[k_max_moment];             ///< history columns, updated in place
  double (*e)[k_block + k_pad];        ///< energy terms, added to; or null
};

struct MomentArgs {
  AddOnParameters one;
  const AddOnParameters* table;  ///< several materials: [pair index]; else null
  double dt;
  int rolling;   ///< 0 none, 1 constant directional torque, 2 elastic-plastic spring and dashpot
  int twisting;  ///< 0 none, 1 spring-slider about the normal
  int rescale;   ///< the stiffness varies along a contact (Hertz): springs shrink with it
  int centred;   ///< as in LawArgs
};

/// Cohesion of one block: attraction proportional to the contact area, added to the force rows of a law.
struct CohesionArgs {
  double one;           ///< energy density [J/m3]
  const double* table;  ///< several materials: [pair index]; else null
  const double* p;      ///< position rows, for the radii; null: the partner is a wall (flat, radius 0)
  const std::int32_t *i, *j;
  int energy;  ///< add to Block::e
};

/// History columns of slots whose set of contacts changed (laws whose columns the narrow phase does not carry itself).
struct CarryArgs {
  const std::uint8_t *before, *now;  ///< one bit per slot
  std::int64_t slots;                ///< multiple of 8
  int columns;
  const double* from[k_max_columns];
  double* to[k_max_columns];
};

/// Narrow phase with contacts that hold beyond touch: a pair that was in contact stays until -delta passes its range.
struct AdhesiveArgs {
  const std::uint8_t* material;  ///< or null
  int materials;
  const double* range;  ///< [pair index] 27 (pi w / (8 E*))^2 [m2]: contact holds while (-delta)^3 <= range R*
};

/// Integration of rows [lo, hi): v(n-1/2) -> v(n+1/2), x(n) -> x(n+1), displacement check against the list's reference.
struct IntegrateArgs {
  std::int32_t lo, hi;
  const double *p, *v;  ///< rows
  double* f;            ///< force rows, indexed by absolute row; left zero for the next user of the scratch
  double *p2, *v2;      ///< new rows
  const double* x0;     ///< list reference rows {x, y, z, skin^2}
  const float* drift;   ///< rows {u, 0}: displacements count from x0 + u drift_time; or null
  long drift_stride;    ///< 4, or 0: one row for all
  double drift_time;    ///< since the lists were made, at the end of the step [s]
  double dt, kick;      ///< kick = dt, or dt/2 in the first step of velocity Verlet
  double gravity[3];
  alignas(32) double upper[4], wrap[4];  ///< domain size per axis (lane 3: 1e300) and period (0 where not periodic)
  alignas(32) double half[4];            ///< half period or 1e300
  double viscous, local;                 ///< background damping coefficients
  double* loss;     ///< [4 rows] or null: column 3 takes what local damping has dissipated in the step [J]
  int stream;       ///< store new rows around the caches: they are not read again before they fall out
  double unstable;  ///< bound on (row sum of stiffness / mass)
  // results
  std::int32_t* out;  ///< rows that left through a non-periodic side (capacity hi - lo)
  std::int32_t out_count;
  int expired;                ///< some row moved farther than its skin (or is not finite)
  std::int32_t unstable_row;  ///< a row whose stiffness sum breaks the bound, or -1
};

/// Levels of the hierarchical cell grid: each particle lives in the level of its reach.
inline constexpr int k_max_levels = 8;

/// Cells of one level; cell (x, y, z) is first_cell + (z * n[1] + y) * n[0] + x.
struct GridLevel {
  std::int32_t n[3];        ///< cells per axis
  std::int32_t first_cell;  ///< in SearchArgs::start
  double inverse[3];        ///< cells per metre
  double top;               ///< largest inflated reach of the level's particles [m]
};

/// Broad phase of rows [lo, hi): sorted candidate rows, each pair once per owner, in three sections. Every array that
/// is written has 16 entries of slack behind its capacity.
struct SearchArgs {
  // particles sorted by cell, padded by 16
  const float *x, *y, *z, *r;  ///< coordinates [m, relative to the domain's lower corner] and inflated reaches
  const std::int32_t* row;     ///< storage rows
  const std::int32_t* start;   ///< [cells + 1] first sorted position of each cell
  const GridLevel* level;      ///< [levels]
  int levels;
  double period[3];           ///< domain size on periodic axes, 0 elsewhere
  const double* p;            ///< position rows of the particles
  const float* reach;         ///< [rows] inflated reach by storage row
  const std::uint8_t* fixed;  ///< [rows] or null: pairs of two fixed rows are left out
  float group_extent;         ///< rows searched together lie in a box of this edge, in reaches
  float group_ratio;          ///< and their reaches differ at most by this factor
  std::int32_t lo, hi;        ///< rows of the chunk
  std::int32_t next;          ///< first row not searched yet (in: lo; out: hi, or where capacity ran out)
  // buffers of one group of rows: candidates and the hits of one row
  float *cx, *cy, *cz, *cr;
  std::int32_t *tag, *hits;
  std::int32_t candidate_capacity;
  std::int32_t *si[3], *sj[3];         ///< sections lower, interior, higher: own row, partner row
  std::int64_t count[3], capacity[3];  ///< filled and available entries per section
};

/// Functions of one instruction set. Laws are indexed by law_index() in kernel_table.hpp.
struct KernelTable {
  const char* name;
  int width;
  void (*narrow)(NarrowArgs&);
  void (*gather[2])(GatherArgs&);  ///< [rotation]
  void (*geometry)(const GeometryArgs&);
  void (*scatter[2])(const ScatterArgs&);  ///< [rotation]
  void (*integrate[2])(IntegrateArgs&);    ///< [rotation]
  void (*search)(SearchArgs&);
  void (*law[32])(Block&, const LawArgs&);
  /// The linear law with friction and one material pair up to the Coulomb limit, and the scatter that applies it. One
  /// after the other they give the bits of law and scatter: the limit's root and division wait in a pass whose time
  /// goes into loads, stores and shuffles instead of in one that multiplications bind.
  double (*trial)(Block&, const LawArgs&);  ///< returns LimitArgs::back
  void (*scatter_limited)(const LimitArgs&);
  /// Forces of what trials have left behind, as a trial leaves them; none exceeds its limit any more.
  double (*late)(LateContacts&, const LawArgs&);              ///< returns LimitArgs::back
  void (*narrow_adhesive)(NarrowArgs&, const AdhesiveArgs&);  ///< history is left to carry
  void (*carry)(const CarryArgs&);
  void (*spin)(const SpinArgs&);
  void (*moments)(MomentBlock&, const MomentArgs&);
  void (*cohesion)(Block&, const CohesionArgs&);
};

}  // namespace talus
