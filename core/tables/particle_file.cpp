// Particle files: bytes, compression, and which reader they go to.
#include "core/tables/particle_file.hpp"

#include <fmt/format.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <new>

#include "core/base/error.hpp"
#include "core/base/input_file.hpp"
#include "core/base/memory.hpp"
#include "core/tables/particle_formats.hpp"

namespace talus {
namespace {

constexpr std::size_t k_max_bytes = std::size_t{1} << 36;
constexpr const char* k_csv_cure = "a header row, then one row per particle";

/// One line of what a file is that is no text of particles, with the cure; or nothing.
std::optional<std::array<const char*, 2>> foreign(std::string_view text) {
  struct Format {
    std::string_view start;
    const char *what, *cure;
  };
  constexpr const char* utf8 = "save it as UTF-8 or plain ASCII";
  constexpr const char* csv = "save the particles as CSV";
  constexpr Format formats[] = {
      {"\xff\xfe", "the file is UTF-16", utf8},
      {"\xfe\xff", "the file is UTF-16", utf8},
      {"ITEM:", "the file is a LAMMPS dump",
       "`talus convert` makes a CSV file of it; a data file (write_data) is read, too"},
      {"<", "the file is XML", "`talus convert` makes a CSV file of .vtp and .pvd; ParaView does too: File, Save Data"},
      {"# vtk DataFile", "the file is a VTK file", "ParaView saves particles as CSV: File, Save Data"},
      {"\x89HDF", "the file is HDF5", "`talus convert` makes a CSV file of a .vtkhdf file"},
      {"PK\x03\x04", "the file is a workbook or a zip archive", csv},
      {"TALUSCP", "the file is a Talus checkpoint", "continue from it with --resume"},
  };
  for (const Format& f : formats)
    if (text.starts_with(f.start)) return {{f.what, f.cure}};
  const std::string_view head = text.substr(0, 4096);
  const auto zeros = std::count(head.begin(), head.end(), '\0');
  if (2 * zeros > std::ssize(head) - 2 && zeros > 1) return {{"the file is UTF-16", utf8}};
  if (zeros > 0) return {{"the file is binary", csv}};
  return {};
}

}  // namespace

std::string read_particle_text(const std::string& path) {
  InputFile input(path, {ErrorCode::scene, "particle file", k_max_bytes, "give the path of a CSV or LAMMPS data file"});
  if (input.size() == 0) throw Error(ErrorCode::scene, "the particle file is empty", path, k_csv_cure);
  const auto refuse_size = [&](double bytes) {
    require_memory(bytes, "reading this particle file", path, "a smaller file, or a machine with more memory");
  };
  refuse_size(static_cast<double>(input.size()));
  const int descriptor = input.release();
  gzFile file = gzdopen(descriptor, "rb");
  if (file == nullptr) {
    ::close(descriptor);
    throw std::bad_alloc();
  }
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> closed_at_the_end(file, gzclose);
  gzbuffer(file, 1 << 18);
  std::string text;
  while (true) {
    constexpr std::size_t chunk = 1 << 20;
    const std::size_t have = text.size();
    if (have > k_max_bytes)
      throw Error(ErrorCode::scene, "the particle file unpacks to more than 64 GiB", path, k_csv_cure);
    // a few MiB may unpack to anything: judged at every doubling, since then the text moves
    if (have + chunk > text.capacity()) {
      refuse_size(2.0 * static_cast<double>(have));
      text.reserve(std::max(2 * have, have + chunk));
    }
    text.resize(have + chunk);
    const int n = gzread(file, text.data() + have, static_cast<unsigned>(chunk));
    text.resize(have + static_cast<std::size_t>(n > 0 ? n : 0));
    int code = 0;
    const char* message = gzerror(file, &code);
    if (n < 0 || (code != Z_OK && code != Z_STREAM_END))
      throw Error(ErrorCode::scene,
                  fmt::format("broken or unreadable particle file: {}", code == Z_ERRNO ? "cannot be read" : message),
                  path);
    if (n <= 0) return text;
  }
}

ParticleFile parse_particles(std::string_view text, const std::string& name, std::span<const Material> materials,
                             std::span<const ShapeSpec> shapes, int shape) {
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  if (const auto other = foreign(text)) throw Error(ErrorCode::scene, (*other)[0], name, (*other)[1]);
  if (!is_lammps_data(text)) return parse_particle_table(text, name, materials, shapes, shape);
  ParticleFile file = parse_lammps_data(text, name, materials);
  if (shape < 0) return file;
  file.shape.assign(file.size(), shape);
  file.scale.assign(file.size(), 0);
  file.turn.assign(file.size(), {1, 0, 0, 0});
  return file;
}

std::string box_note(const ParticleFile& file, const std::string& name, Vec3 lower, Vec3 upper) {
  if (!file.box) return {};
  const auto& [from, to] = *file.box;
  bool same = true;
  std::string ours, theirs;
  for (int k = 0; k < 3; ++k) {
    const double tolerance = 1e-6 * (upper[k] - lower[k]);  // files are written with fewer digits
    same = same && std::fabs(from[k] - lower[k]) <= tolerance && std::fabs(to[k] - upper[k]) <= tolerance;
    theirs += fmt::format("{}{:g} to {:g}", k == 0 ? "" : ", ", from[k], to[k]);
    ours += fmt::format("{}{:g} to {:g}", k == 0 ? "" : ", ", lower[k], upper[k]);
  }
  if (same) return {};
  return fmt::format("{}: its box ({}) is not the domain ({}), which counts; positions are taken as they are", name,
                     theirs, ours);
}

ParticleFile read_particle_file(const std::string& path, std::span<const Material> materials,
                                std::span<const ShapeSpec> shapes, int shape) {
  return parse_particles(read_particle_text(path), path, materials, shapes, shape);
}

}  // namespace talus
