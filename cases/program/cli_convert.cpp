// `talus convert FROM TO`: particles in the format of another program, told by the name of TO; FROM is a run, a
// checkpoint or a file of any of these formats. Invariant: an existing file is never replaced unless asked, and TO
// appears whole or not at all.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <numeric>
#include <optional>

#include "cases/program/cli.hpp"
#include "cases/program/cli_console.hpp"
#include "cases/program/cli_folder.hpp"
#include "core/base/count.hpp"
#include "core/base/text.hpp"
#include "core/frame/quantities.hpp"
#include "core/io/atomic_file.hpp"
#include "core/io/particle_export.hpp"
#include "core/io/particle_frames.hpp"
#include "core/io/text_frames.hpp"
#include "core/io/vtkhdf.hpp"
#include "core/io/vtp.hpp"
#include "core/tables/particle_file.hpp"
#include "scheduler/simulation.hpp"

namespace talus::cli {
namespace fs = std::filesystem;
namespace {

enum class Format { csv, dump, xyz, vtp, pvd, vtkhdf };

struct Ending {
  std::string_view text;
  Format format;
  bool many;  ///< holds any number of frames
};
constexpr Ending k_endings[] = {{".csv", Format::csv, false},       {".dump", Format::dump, true},
                                {".lammpstrj", Format::dump, true}, {".xyz", Format::xyz, true},
                                {".extxyz", Format::xyz, true},     {".vtp", Format::vtp, false},
                                {".pvd", Format::pvd, true},        {".vtkhdf", Format::vtkhdf, true}};

const Ending& ending_of(const std::string& path) {
  std::string list;
  for (const Ending& e : k_endings) {
    if (fs::path(path).extension() == e.text) return e;
    list += (list.empty() ? "" : ", ") + std::string(e.text);
  }
  throw Error(ErrorCode::usage, "the ending of the name tells no format", path, "allowed: " + list);
}

/// Where frames come from, one after the other.
struct Input {
  std::optional<ParticleFrames> frames;
  std::optional<Frame> single;     ///< of a checkpoint or a table
  std::optional<TextFrames> text;  ///< of a dump or XYZ
  std::optional<Scene> scene;      ///< of the run, for box and names
  std::size_t size() const { return single ? 1 : text ? text->frames.size() : frames->steps().size(); }
  Frame frame(std::size_t k) const { return single ? *single : text ? text->frames[k] : frames->frame(k); }
  std::optional<Domain> domain(std::size_t k) const {
    if (text) return text->domains[k];
    return scene ? std::optional<Domain>(scene->domain) : std::nullopt;
  }
  std::vector<Material> materials() const {
    if (!text) return scene ? scene->materials : std::vector<Material>{};
    std::vector<Material> named(text->species.size());
    for (std::size_t k = 0; k < named.size(); ++k) named[k].name = text->species[k];
    return named;
  }
};

/// Tables have their rows in any order; writers take them by id.
void into_id_order(Frame& f) {
  std::vector<std::size_t> order(f.id.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return f.id[a] < f.id[b]; });
  const auto arrange = [&order](auto& list) {
    auto sorted = list;
    for (std::size_t k = 0; k < list.size(); ++k) sorted[k] = list[order[k]];
    list = std::move(sorted);
  };
  arrange(f.id);
  arrange(f.x);
  arrange(f.v);
  arrange(f.w);
  arrange(f.r);
  arrange(f.material);
  arrange(f.fixed);
}

Frame frame_of_table(const std::string& path) {
  // Materials by index only: a table alone does not tell their names.
  std::vector<Material> unnamed(256);
  for (std::size_t k = 0; k < unnamed.size(); ++k) unnamed[k].name = fmt::format("M{}", k);
  ParticleFile file = read_particle_file(path, unnamed);
  Frame f;
  for (const std::string& note : file.notes) tell("talus: note: {}\n", note);
  f.id = std::move(file.id);
  for (std::size_t i = f.id.size(); i < file.size(); ++i) f.id.push_back(static_cast<ParticleId>(i));
  f.x = std::move(file.x);
  f.v = std::move(file.v);
  f.w = std::move(file.w);
  f.r = std::move(file.r);
  f.material = std::move(file.material);
  f.fixed = std::move(file.fixed);
  into_id_order(f);
  return f;
}

/// The ending without .gz.
std::string kind_of(const std::string& path) {
  const fs::path name(path);
  return name.extension() == ".gz" ? name.stem().extension().string() : name.extension().string();
}
bool is_text_frames(const std::string& path) {
  const std::string kind = kind_of(path);
  return kind == ".dump" || kind == ".lammpstrj" || kind == ".xyz" || kind == ".extxyz";
}
bool is_table(const std::string& path) {
  const std::string kind = kind_of(path);
  return kind == ".csv" || kind == ".tsv" || kind == ".txt" || fs::path(path).extension() == ".gz";
}

Input open_input(const std::string& path, const RunOptions& engine) {
  if (!fs::exists(path)) throw Error(ErrorCode::io, "no such file or folder", path);
  Input in;
  const std::string extension = fs::path(path).extension().string();
  std::string folder = path, file = path;
  if (fs::is_directory(path)) {
    const auto found = ParticleFrames::find(path);
    if (!found)
      throw Error(ErrorCode::io, "holds no particle frames", path,
                  "run with output.particles_every > 0, or give a checkpoint of it");
    file = *found;
  } else {
    folder = fs::path(path).parent_path().string();
    if (folder.empty()) folder = ".";
  }
  if (!fs::exists(fs::path(folder) / "scene.toml") && fs::path(folder).filename() == "vtp")
    folder = (fs::path(folder) / "..").string();  // frames lie one below
  if (fs::exists(fs::path(folder) / "scene.toml")) in.scene = stored_scene(RunFolder::open(folder));
  if (extension == ".tcp") {
    const Stored stored = open_stored(path);
    in.single = Simulation(stored.scene, engine, stored.checkpoint).frame({});
    if (!in.scene) in.scene = stored.scene;
  } else if (is_text_frames(path)) {
    in.text = read_text_frames(path);
    for (const std::string& note : in.text->notes) tell("talus: note: {}\n", note);
  } else if (is_table(path)) {
    in.single = frame_of_table(path);
  } else {
    in.frames.emplace(file);
  }
  return in;
}

/// First and last frame to write.
std::pair<std::size_t, std::size_t> chosen(const Options& options, const Input& in, const Ending& ending) {
  const std::size_t n = in.size();
  if (n == 0) throw Error(ErrorCode::io, "holds no frame", options.files.at(0));
  const std::string word = options.frame.empty() ? (ending.many ? "all" : "last") : options.frame;
  if (word == "all" && (ending.many || n == 1)) return {0, n - 1};
  if (word == "all")
    throw Error(ErrorCode::usage, fmt::format("'{}' holds one frame, and there are {}", ending.text, n), "--frame all",
                "give --frame last or a number from 0");
  if (word == "last") return {n - 1, n - 1};
  std::size_t k = 0;
  bool good = !word.empty() && word.size() < 10;
  for (const char c : word) good = good && c >= '0' && c <= '9', k = 10 * k + static_cast<std::size_t>(c - '0');
  if (!good || k >= n)
    throw Error(ErrorCode::usage, "no such frame", "--frame " + shown(word),
                fmt::format("allowed: all, last, or 0 to {}", n - 1));
  return {k, k};
}

ParticleColumns columns_of(const Input& in, std::size_t first, std::size_t last) {
  for (std::size_t k = first; k <= last; ++k) {
    const Frame f = in.frame(k);
    if (f.x.empty()) continue;
    return ParticleColumns::of(f);
  }
  return {};
}

void write_text(const Input& in, Format format, const std::string& to, std::size_t first, std::size_t last) {
  const std::vector<Material> materials = in.materials();
  AtomicFile out(to);
  for (std::size_t k = first; k <= last; ++k) {
    const Frame f = in.frame(k);
    out.write(format == Format::csv
                  ? csv_text(f, in.scene ? std::span<const ShapeSpec>(in.scene->shapes) : std::span<const ShapeSpec>())
              : format == Format::dump ? lammps_dump_text(f, in.domain(k))
                                       : extended_xyz_text(f, in.domain(k), materials));
  }
  out.commit();
}

/// Columns of the frame that the format does not have, as a list.
std::string left_out(const Frame& f, Format format) {
  const bool csv = format == Format::csv, other = format == Format::dump || format == Format::xyz;
  std::string list;
  const auto name = [&list](const char* column) { list += (list.empty() ? "" : ", ") + std::string(column); };
  if (other && !f.fixed.empty()) name("fixed");
  const bool of_spheres = other || (csv && !f.bodies.empty());  // a row of a table of bodies has none of these
  if (of_spheres && !f.coordination.empty()) name("coordination");
  if ((csv || other) && !f.stress.empty()) name("stress");
  if (other)
    for (const ExtraColumn& e : f.extra)
      if (e.name != "body") name(e.name.c_str());
  if (!csv && !f.bodies.empty()) name("bodies: particles are their spheres");
  return list;
}

void write_pvd(const Input& in, const std::string& to, std::size_t first, std::size_t last,
               const ParticleColumns& columns) {
  const fs::path path(to);
  PvdCollection list(path.parent_path().empty() ? "." : path.parent_path().string(), path.stem().string());
  for (std::size_t k = first; k <= last; ++k) {
    const Frame f = in.frame(k);
    write_vtp(list.path(f.step), particle_poly(f, columns), f.time);
    list.add(f.step, f.time);
  }
}

void write_vtkhdf(const Input& in, const std::string& to, std::size_t first, std::size_t last,
                  const ParticleColumns& columns) {
  try {
    VtkHdfWriter out(to, columns);
    for (std::size_t k = first; k <= last; ++k) out.append(in.frame(k));
  } catch (...) {
    std::error_code ignored;
    fs::remove(to, ignored);
    throw;
  }
}

}  // namespace

int convert(const Options& options) {
  const std::string &from = options.files.at(0), &to = options.files.at(1);
  const Ending& ending = ending_of(to);
  std::error_code ignored;
  if (fs::equivalent(from, to, ignored)) throw Error(ErrorCode::usage, "is the input itself", to, "give another name");
  if (fs::exists(to) && (!options.overwrite || !fs::is_regular_file(to)))
    throw Error(ErrorCode::usage, "is there already", to, "--overwrite replaces a file");
  const Input in = open_input(from, options.run);
  const auto [first, last] = chosen(options, in, ending);
  switch (ending.format) {
    case Format::csv:
    case Format::dump:
    case Format::xyz:
      write_text(in, ending.format, to, first, last);
      break;
    case Format::vtp: {
      const Frame f = in.frame(first);
      write_vtp(to, particle_poly(f, columns_of(in, first, first)), f.time);
      break;
    }
    case Format::pvd:
      write_pvd(in, to, first, last, columns_of(in, first, last));
      break;
    case Format::vtkhdf:
      write_vtkhdf(in, to, first, last, columns_of(in, first, last));
      break;
  }
  if (const std::string lost = left_out(in.frame(first), ending.format); !lost.empty() && !options.quiet)
    tell("talus: note: {}: this format has no place for {}\n", to, lost);
  if (!options.quiet) put("{}: {} frame{}\n", shown_path(to), last - first + 1, last == first ? "" : "s");
  return 0;
}

}  // namespace talus::cli
