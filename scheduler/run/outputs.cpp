// Outputs of a run; see outputs.hpp.
#include "scheduler/run/outputs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <functional>
#include <limits>
#include <system_error>
#include <utility>
#include <vector>

#include "core/frame/averages.hpp"
#include "core/frame/body_shares.hpp"
#include "core/frame/quantities.hpp"
#include "core/grains/body_shape.hpp"
#include "core/io/series.hpp"
#include "core/io/vtkhdf.hpp"
#include "core/io/vtp.hpp"
#include "scheduler/run/failure.hpp"
#include "scheduler/run/schedule.hpp"

namespace talus {
namespace {

bool walls_change(const Scene& scene) {
  return std::any_of(scene.walls.begin(), scene.walls.end(),
                     [](const WallSpec& w) { return w.motion.any() || w.appear > 0 || w.vanish < k_never; });
}

/// The writer that `open` makes: of a new file, or where it is resumed of the file there. One that cannot be continued
/// is set aside: the trajectory goes on whatever happened to a picture of it.
template <class Open>
auto continued(const RunFolder& folder, const std::string& file, std::int64_t resume_step, const Tell& warn,
               Open open) {
  if (resume_step < 0) return open(false);
  try {
    return open(true);
  } catch (const CannotContinue& e) {
    const std::string aside = folder.set_aside(file, resume_step);
    warn(fmt::format("{}; it is now {}, and a new one begins", e.why(), aside));
  }
  return open(false);
}

/// Frames of the interrupted run in a format that this one does not write end here.
void tell_left(const std::string& file, const char* key, std::int64_t resume_step, const Tell& warn) {
  std::error_code ignored;
  if (resume_step >= 0 && std::filesystem::exists(file, ignored))
    warn(fmt::format("{} is not continued: {} is false", file, key));
}

/// One kind of picture (particles, walls, contacts) in the formats that the scene asks for.
class FrameStream {
 public:
  using Content = VtkHdfWriter::Content;
  using MakePoly = std::function<PolyData(const Frame&)>;
  FrameStream(const RunFolder& folder, const Scene& scene, const char* stem, Content content,
              const ParticleColumns& columns, MakePoly poly, std::int64_t resume_step, const Tell& warn)
      : poly_(std::move(poly)) {
    const std::string file = folder.path(std::string(stem) + ".vtkhdf");
    if (scene.output.vtkhdf) {
      hdf_ = continued(folder, file, resume_step, warn, [&](bool resume) {
        return resume ? VtkHdfWriter::resume(file, columns, content, resume_step)
                      : VtkHdfWriter(file, columns, content);
      });
      files_.push_back(file);
    } else {
      tell_left(file, "output.vtkhdf", resume_step, warn);
    }
    const std::string list = folder.path(std::string(stem) + ".pvd");
    if (scene.output.vtp) {
      pvd_ = continued(folder, list, resume_step, warn, [&](bool resume) {
        return resume ? PvdCollection::resume(folder.dir(), stem, resume_step) : PvdCollection(folder.dir(), stem);
      });
      files_.push_back(list);
    } else {
      tell_left(list, "output.vtp", resume_step, warn);
    }
  }
  void write(const Frame& frame) {
    if (hdf_ && hdf_->last_step() < frame.step) hdf_->append(frame);
    if (pvd_ && pvd_->last_step() < frame.step) {
      write_vtp(pvd_->path(frame.step), poly_(frame), frame.time);
      pvd_->add(frame.step, frame.time);
    }
  }
  void check() const {
    if (hdf_) hdf_->check();
    if (pvd_) pvd_->check();
  }
  bool empty() const { return (!hdf_ || hdf_->last_step() < 0) && (!pvd_ || pvd_->last_step() < 0); }
  /// The .pvd where there is one: every ParaView reads it.
  std::string best_file() const { return files_.empty() ? "" : files_.back(); }

 private:
  MakePoly poly_;
  std::optional<VtkHdfWriter> hdf_;
  std::optional<PvdCollection> pvd_;
  std::vector<std::string> files_;
};
}  // namespace

struct RunOutputs::Impl {
  RunFolder folder;
  const Scene scene;
  Repeat frames, rows, checkpoints;
  WallInterval by_clock;  ///< checkpoints besides those by steps
  bool moving_walls;
  std::optional<FrameStream> particles, walls, contacts;
  std::optional<PvdCollection> grid, bodies;
  std::vector<PvdCollection> part_grids;  ///< in the order of Simulation::part_grids()
  std::optional<SeriesWriter> series;
  std::optional<BodyShares> shares;  ///< where regions or a grid are averaged over
  bool row_needs_frame = false;
  std::int64_t start = 0;  ///< step that the run begins with
  bool resumed = false;
  std::int64_t checkpoint_step = -1;  ///< of the last checkpoint written or read
  std::string record;                 ///< of the scene, as it stands in checkpoints

  Impl(const RunFolder& f, const Scene& s, std::int64_t every, std::string scene_record)
      : folder(f),
        scene(s),
        frames(s.output.particles_every, s.dt),
        rows(s.output.csv_every, s.dt),
        checkpoints(static_cast<double>(every), 1),
        by_clock(s.output.checkpoint_wall),
        moving_walls(walls_change(s)),
        record(std::move(scene_record)) {
    if (s.output.grid.on || !s.output.regions.empty()) shares.emplace(scene);
  }

  void save(const Simulation& simulation, const std::string& path) const {
    CheckpointWriter writer;
    fill(simulation, writer);
    writer.commit(path);
  }
  void fill(const Simulation& simulation, CheckpointWriter& writer) const {
    simulation.save(writer);
    writer.add_view("scene", record.data(), record.size());
  }

  void write_frame(const Simulation& simulation) {
    FrameRequest request;
    request.coordination = scene.output.coordination;
    request.stress = scene.output.stress;
    request.contacts = scene.output.contacts;
    request.walls = walls.has_value();
    const Frame frame = simulation.frame(request);
    if (particles) particles->write(frame);
    if (contacts) contacts->write(frame);
    if (walls && (moving_walls || walls->empty())) walls->write(frame);
    if (bodies && bodies->last_step() < frame.step) {
      write_vtp(bodies->path(frame.step), body_poly(frame), frame.time);
      bodies->add(frame.step, frame.time);
    }
    if (grid && grid->last_step() < frame.step) {
      write_vti(grid->path(frame.step), average_grid(frame, scene, scene.output.grid.cells, *shares), frame.time);
      grid->add(frame.step, frame.time);
    }
    if (!part_grids.empty()) write_part_grids(simulation.part_grids(), frame);
  }

  void write_part_grids(const std::vector<std::pair<std::string, GridData>>& grids, const Frame& frame) {
    for (std::size_t k = 0; k < grids.size(); ++k) {
      if (part_grids[k].last_step() >= frame.step) continue;
      write_vti(part_grids[k].path(frame.step), grids[k].second, frame.time);
      part_grids[k].add(frame.step, frame.time);
    }
  }

  SeriesRow row_of(const Simulation& simulation, const std::optional<Frame>& frame) const {
    const Counters c = simulation.counters();
    SeriesRow row;
    row.step = simulation.step();
    row.time = simulation.time();
    row.particles = simulation.particles();
    row.contacts = c.contacts;
    row.wall_contacts = c.wall_contacts;
    row.safe_pairs = c.step_safe_pairs;
    row.inserted = c.inserted;
    row.removed = c.removed;
    row.removed_mass = c.removed_mass;
    row.kinetic_energy = simulation.kinetic_energy();
    if (scene.output.energies) row.energies = simulation.energies();
    row.planes = simulation.planes();
    for (const PartValue& v : simulation.part_values()) row.parts.push_back(v.value);
    if (frame) {
      row.walls = frame->wall_loads;
      for (const auto& average : scene.output.regions)
        row.regions.push_back(average_region(*frame, scene, average.region, *shares));
    }
    return row;
  }
};

RunOutputs::RunOutputs(const RunFolder& folder, const Simulation& simulation, const CheckpointReader* checkpoint,
                       bool append, std::int64_t checkpoint_every, std::string record, const Tell& warn)
    : impl_(std::make_unique<Impl>(folder, simulation.scene(), checkpoint_every, std::move(record))) {
  Impl& m = *impl_;
  const Scene& scene = m.scene;
  m.start = simulation.step();
  m.resumed = checkpoint != nullptr;
  if (m.resumed) m.checkpoint_step = m.start;
  const std::int64_t resume_step = append ? m.start : -1;

  FrameRequest names;
  names.walls = true;
  std::vector<std::string> walls;
  const Frame example = simulation.frame(names);
  for (const WallSurface& w : example.walls) walls.push_back(w.name);

  if (m.frames.on()) {
    using Content = VtkHdfWriter::Content;
    const ParticleColumns columns = ParticleColumns::of(scene, example);
    m.particles.emplace(
        folder, scene, "particles", Content::particles, columns,
        [columns](const Frame& f) { return particle_poly(f, columns); }, resume_step, warn);
    if (!walls.empty()) m.walls.emplace(folder, scene, "walls", Content::walls, columns, wall_poly, resume_step, warn);
    if (scene.output.contacts)
      m.contacts.emplace(folder, scene, "contacts", Content::contacts, columns, contact_poly, resume_step, warn);
    if (makes_bodies(scene))
      m.bodies = continued(folder, folder.path("bodies.pvd"), resume_step, warn, [&](bool resume) {
        return resume ? PvdCollection::resume(folder.dir(), "bodies", resume_step)
                      : PvdCollection(folder.dir(), "bodies");
      });
    for (const auto& [name, cells] : simulation.part_grids())
      m.part_grids.push_back(
          continued(folder, folder.path(name + ".pvd"), resume_step, warn, [&, stem = name](bool resume) {
            return resume ? PvdCollection::resume(folder.dir(), stem, resume_step, "vti")
                          : PvdCollection(folder.dir(), stem, "vti");
          }));
    if (scene.output.grid.on) {
      m.grid = continued(folder, folder.path("grid.pvd"), resume_step, warn, [&](bool resume) {
        return resume ? PvdCollection::resume(folder.dir(), "grid", resume_step, "vti")
                      : PvdCollection(folder.dir(), "grid", "vti");
      });
    }
  }
  if (m.rows.on()) {
    m.row_needs_frame = !walls.empty() || !scene.output.regions.empty();
    SeriesLayout layout = SeriesLayout::of(scene, walls);
    for (const PartValue& v : simulation.part_values()) layout.parts.push_back(v.name);
    m.series = continued(folder, folder.series(), resume_step, warn, [&](bool resume) {
      return resume ? SeriesWriter::resume(folder.series(), layout, resume_step)
                    : SeriesWriter(folder.series(), layout);
    });
    if (m.resumed) m.series->start_from(m.row_of(simulation, std::nullopt));
  }
}

RunOutputs::~RunOutputs() = default;

std::int64_t RunOutputs::next_stop(std::int64_t step) const {
  std::int64_t stop = std::min(impl_->frames.after(step), impl_->rows.after(step));
  return std::min(stop, impl_->checkpoints.after(step));
}

void RunOutputs::write(const Simulation& simulation) {
  Impl& m = *impl_;
  const std::int64_t step = simulation.step();
  // At the step of a resume the state has no forces yet; the interrupted run wrote that row.
  const bool fresh = step > m.start || !m.resumed;
  if (m.rows.due(step) && fresh) {
    std::optional<Frame> frame;
    if (m.row_needs_frame) {
      FrameRequest request;
      request.wall_loads = true;
      request.coordination = m.scene.output.coordination;
      request.stress = m.scene.output.stress;
      frame = simulation.frame(request);
    }
    m.series->append(m.row_of(simulation, frame));
  }
  if (m.frames.due(step)) m.write_frame(simulation);
  if ((m.checkpoints.due(step) || m.by_clock.due()) && step > m.start) checkpoint(simulation);
}

void RunOutputs::check() const {
  const Impl& m = *impl_;
  for (const auto* stream : {&m.particles, &m.walls, &m.contacts})
    if (*stream) (*stream)->check();
  if (m.grid) m.grid->check();
  if (m.bodies) m.bodies->check();
  for (const PvdCollection& p : m.part_grids) p.check();
  if (m.series) m.series->check();
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(m.folder.scene(), ignored))
    throw Error(ErrorCode::io, "was deleted during the run", m.folder.scene(),
                "copy the scene back to this name: --resume needs it");
}

std::string RunOutputs::checkpoint(const Simulation& simulation) {
  Impl& m = *impl_;
  const std::int64_t step = simulation.step();
  std::error_code ignored;
  if (step != m.checkpoint_step || !std::filesystem::exists(m.folder.checkpoint(step), ignored)) {
    m.by_clock.begin();
    CheckpointWriter writer;
    m.fill(simulation, writer);
    m.folder.save_checkpoint(writer, step);
    m.checkpoint_step = step;
    m.by_clock.done();
  }
  return m.folder.checkpoint(step);
}

std::string RunOutputs::dump_failure(const Simulation& simulation) noexcept {
  const std::string path = impl_->folder.path("failed.tcp");
  try {
    impl_->save(simulation, path);
  } catch (...) {
    return {};
  }
  try {
    const Frame frame = simulation.frame({});
    const ParticleColumns columns = ParticleColumns::of(impl_->scene, frame).without_forces();
    write_vtp(impl_->folder.path("failed.vtp"), particle_poly(frame, columns), frame.time);
    write_neighbourhood(simulation, impl_->folder.path("failed_near.csv"));
  } catch (...) {
    // The checkpoint is there; the pictures can be made from it.
  }
  return path;
}

std::string RunOutputs::paraview_file() const { return impl_->particles ? impl_->particles->best_file() : ""; }

std::string RunOutputs::csv_file() const { return impl_->series ? impl_->folder.series() : ""; }

}  // namespace talus
