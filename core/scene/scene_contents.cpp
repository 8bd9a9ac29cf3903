// See scene_contents.hpp.
#include "core/scene/scene_contents.hpp"

#include <fmt/format.h>
#include <xxhash.h>

#include <filesystem>
#include <fstream>

#include "core/scene/scene.hpp"

namespace talus {
namespace {

constexpr std::string_view k_line = "# content of ";

/// Empty where it cannot be read.
std::string sum_of(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  XXH64_state_t* state = XXH64_createState();
  XXH64_reset(state, 0);
  std::vector<char> block(1 << 16);
  while (in.read(block.data(), static_cast<std::streamsize>(block.size())) || in.gcount() > 0)
    XXH64_update(state, block.data(), static_cast<std::size_t>(in.gcount()));
  const std::string sum = in.eof() ? fmt::format("{:016x}", XXH64_digest(state)) : std::string();
  XXH64_freeState(state);
  return sum;
}

}  // namespace

std::vector<FileContent> contents_of(const Scene& scene) {
  namespace fs = std::filesystem;
  std::vector<FileContent> all;
  const auto add = [&](const char* section, std::size_t k, const char* key, const std::string& file) {
    std::error_code ignored;
    const fs::path at = fs::path(file).is_absolute() ? fs::path(file) : fs::path(scene.directory) / file;
    if (file.empty() || !fs::is_regular_file(at, ignored)) return;
    if (std::string sum = sum_of(at.string()); !sum.empty())
      all.push_back({fmt::format("{}.{}.{}", section, k, key), std::move(sum)});
  };
  for (std::size_t k = 0; k < scene.walls.size(); ++k) add("wall", k, "file", scene.walls[k].file);
  for (std::size_t k = 0; k < scene.shapes.size(); ++k) add("shape", k, "file", scene.shapes[k].file);
  for (std::size_t k = 0; k < scene.conversion.grain.size(); ++k)
    add("material", k, "grain", scene.conversion.grain[k]);
  return all;
}

std::string contents_text(const std::vector<FileContent>& contents) {
  std::string text;
  for (const FileContent& c : contents) text += fmt::format("{}{} {}\n", k_line, c.path, c.sum);
  return text;
}

std::vector<FileContent> contents_in(std::string_view record) {
  std::vector<FileContent> all;
  while (!record.empty()) {
    const std::size_t end = record.find('\n');
    std::string_view line = record.substr(0, end);
    record.remove_prefix(end == std::string_view::npos ? record.size() : end + 1);
    if (!line.starts_with(k_line)) continue;
    line.remove_prefix(k_line.size());
    if (const std::size_t space = line.find(' '); space != std::string_view::npos)
      all.push_back({std::string(line.substr(0, space)), std::string(line.substr(space + 1))});
  }
  return all;
}

}  // namespace talus
