// Sources of particles: initial states from files and packings, streams and batches at run time.
// Who calls it: scheduler/ (construction and the `insert` node). Invariants: I4 (own log/exp, counter-based random
// numbers), I6 (its whole state is saved and restored), a batch is a function of scene, step and present particles.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/grains/body_shape.hpp"
#include "core/grains/population.hpp"
#include "core/grains/size_sampler.hpp"
#include "core/scene/scene.hpp"

namespace talus {

/// A body of several spheres among new particles.
struct NewBody {
  std::int32_t first = 0, count = 0;  ///< its spheres: so many particles, one after another
  std::int32_t shape = 0;             ///< index into scene.shapes
  double scale = 1, mass = 0;         ///< mass [kg]
  Vec3 x, v;                          ///< of the centre of mass [m], [m/s]
  shapes::Quaternion turn;            ///< from the principal axes to space
  Vec3 w{};                           ///< [rad/s]
  bool fixed = false;                 ///< held
};

/// Particles to append, in id order. All vectors have the same length.
struct NewParticles {
  std::vector<Vec3> x, v, w;  ///< [m], [m/s], [rad/s]
  std::vector<double> r;      ///< [m]
  std::vector<std::uint8_t> material;
  std::vector<std::uint8_t> fixed;   ///< 1: frozen
  std::vector<std::int16_t> group;   ///< index into scene.groups or -1
  std::vector<std::int32_t> source;  ///< index into scene.sources
  std::vector<NewBody> bodies;       ///< ascending
  std::size_t size() const noexcept { return x.size(); }
  /// A body is one.
  std::int64_t grains() const noexcept {
    auto n = static_cast<std::int64_t>(size());
    for (const NewBody& b : bodies) n -= b.count - 1;
    return n;
  }
};

/// Present particles as the engine stores them: rows {x, y, z, r} of 4 doubles, positions relative to the domain's
/// lower corner; dead rows have x > 1e100.
struct PresentParticles {
  std::span<const double> rows;
  std::size_t size() const noexcept { return rows.size() / 4; }
};

class Occupied;
class WallSet;
class SourceWalls;
class ClosedWalls;
struct ParticleFile;

/// A stream that could not place in a batch what was due: placed of wanted particles; the rest waits for room.
struct Shortfall {
  std::size_t source = 0;
  std::int64_t placed = 0, wanted = 0;
};

class Insertion {
 public:
  /// Reads the files of file sources. Errors: Error{scene} naming file and row for a particle outside the domain or a
  /// value that is not finite or positive; for a source of which it is plain that its particles can never fit into its
  /// region or into memory (with the number that fits).
  explicit Insertion(const Scene& scene);
  ~Insertion();
  /// Particles of step 0: all file sources, then lattice/random sources with start <= 0, in scene order, clear of
  /// `walls` (the engine's, set to step 0; nullptr: there are none).
  /// Errors: Error{scene} for an overlap in a file, with a particle or a wall, deeper than allowed (lists the first),
  /// a pack that does not fit (says how many fitted).
  NewParticles initial(const WallSet* walls = nullptr);
  /// First step >= n at which a batch is due (step 0 included: a stream's first batch), or INT64_MAX.
  std::int64_t next_step(std::int64_t n) const;
  /// The batch of step n (may be empty where nothing fits yet); advances the state. No overlap with `present`, also
  /// across periodic faces, nor with `walls` at step n.
  NewParticles batch(std::int64_t n, const PresentParticles& present, const WallSet* walls = nullptr);
  const std::vector<Shortfall>& shortfalls() const noexcept { return shortfalls_; }  ///< of the latest batch
  std::int64_t inserted() const noexcept { return inserted_; }
  /// What was ignored or assumed in the initial files, one line each.
  const std::vector<std::string>& notes() const noexcept { return notes_; }
  /// All mutable state as bytes (checkpoint section "insertion") and back. Error{io} if it does not fit the scene.
  std::vector<std::uint8_t> save() const;
  void load(std::span<const std::uint8_t> bytes);
  /// Smallest and largest radius that any source can ever deliver [m] (file sources are read) for dt and cell limits.
  Population population() const;  ///< grains that there are or will be within the scene's duration, and their speeds
  std::vector<char> materials() const;  ///< [materials] not 0 where a particle of it is or will be
  double smallest_radius() const;
  double largest_radius() const;
  double largest_reach() const;  ///< from the centre of a body or grain to its farthest point [m]
  bool any_fixed() const;        ///< some particle of the initial files is frozen

 private:
  struct SourceState {
    std::int64_t drawn = 0;    ///< counter of random draws (particle sizes and positions)
    std::int64_t number = 0;   ///< delivered
    double mass = 0;           ///< delivered [kg]
    std::int64_t batches = 0;  ///< batches tried
    double carry = 0;          ///< fraction of a particle (or kg) owed by a rate
  };
  void check_state() const;  ///< Error{io}: numbers that no run can have left
  struct Site;               ///< where a particle may go (insertion_fill.cpp)
  // insertion_limits.cpp
  void check_region(std::size_t source) const;
  double check_numbers(std::size_t source) const;
  void check_memory() const;
  // insertion_file.cpp
  void read_file(std::size_t source);
  // insertion_bodies.cpp
  void take_rows(std::size_t source, const std::string& path, ParticleFile& file);
  NewBody body_of_row(const std::string& path, const ParticleFile& file, std::size_t row, int material) const;
  void place_spheres(const NewBody& body, NewParticles& p) const;
  std::size_t tiles(std::size_t source) const;
  Vec3 tile_size(std::size_t source) const;  ///< [m]
  void append_tiles(std::size_t source, NewParticles& out) const;
  std::string place_in_file(std::size_t particle) const;
  std::vector<std::int32_t> in_rows(const NewParticles& p, double largest) const;
  void check_overlaps(const NewParticles& p, const SourceWalls& walls) const;
  // insertion.cpp
  std::int64_t due_step(std::size_t source, std::int64_t n) const;
  bool exhausted(std::size_t source) const;
  // insertion_fill.cpp
  double next_radius(std::size_t source) const;
  double mass_of(std::size_t source, double r) const;
  /// r: of a sphere, or of the sphere of equal volume.
  void deliver(std::size_t source, Vec3 x, double r, NewParticles& out);
  void append(std::size_t source, Vec3 x, double r, Vec3 v, NewParticles& out) const;
  void append_body(std::size_t source, Vec3 x, double r, Vec3 v, NewParticles& out) const;
  const BodyShape* shape_of(std::size_t source) const;  ///< null: spheres, or a file
  const BodyShape& shape_of(const NewBody& body) const;
  shapes::Quaternion turn_of(std::size_t source, std::int64_t number) const;
  void fill_lattice(std::size_t source, Site& site, NewParticles& out);
  void fill_random(std::size_t source, Site& site, NewParticles& out);
  void fill_stream(std::size_t source, Site& site, NewParticles& out);
  void fill(std::size_t source, const NewParticles& before, const PresentParticles& present, const WallSet* walls,
            NewParticles& out);

  Scene scene_;  ///< bodies without a size have that of their shape
  std::vector<SourceState> state_;
  std::vector<SizeSampler> samplers_;            ///< one per source
  std::vector<NewParticles> files_;              ///< one per source, filled for file sources; read once; one tile
  std::vector<std::vector<std::int64_t>> rows_;  ///< line in the file of each particle of files_
  std::unique_ptr<const ClosedWalls> closed_;    ///< only where a source keeps to one side of closed walls
  std::vector<Shortfall> shortfalls_;
  std::vector<std::string> notes_;
  std::int64_t inserted_ = 0;
};

}  // namespace talus
