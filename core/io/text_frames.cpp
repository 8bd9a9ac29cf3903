// Which reader a text file of frames goes to; see text_frames.hpp.
#include "core/io/text_frames.hpp"

#include "core/base/error.hpp"
#include "core/tables/particle_file.hpp"

namespace talus {

TextFrames read_text_frames(const std::string& path) {
  std::string text;
  try {
    text = read_particle_text(path);
  } catch (const Error& e) {
    throw Error(ErrorCode::io, e.what());
  }
  return std::string_view(text).starts_with("ITEM:") ? parse_lammps_dump(text, path) : parse_extended_xyz(text, path);
}

}  // namespace talus
