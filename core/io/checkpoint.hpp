// Checkpoint container: named binary sections with one xxh3 checksum each. File layout, little endian:
// magic "TALUSCP1", uint32 section count, then per section {uint16 name length, name, uint64 size, uint64 xxh3, bytes},
// then xxh3 of everything before. Written as scratch file -> fsync -> rename -> fsync(directory), so that a reader sees
// the old or the new file, never a torn one. Bytes hold no date, host, thread count or ISA (R2).
#pragma once

#include <cstdint>
#include <cstring>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "core/base/error.hpp"

namespace talus {

class CheckpointWriter {
 public:
  CheckpointWriter() = default;
  CheckpointWriter(CheckpointWriter&&) = default;  // no copies: sections are views of their own bytes
  CheckpointWriter& operator=(CheckpointWriter&&) = default;
  void add(std::string name, std::vector<std::uint8_t> bytes);
  template <class T>
  void add_array(std::string name, const T* data, std::size_t n) {
    static_assert(std::is_trivially_copyable_v<T>);
    std::vector<std::uint8_t> b(n * sizeof(T));
    if (n != 0) std::memcpy(b.data(), data, b.size());
    add(std::move(name), std::move(b));
  }
  /// The same without a copy: the data have to stay as they are until commit().
  template <class T>
  void add_view(std::string name, const T* data, std::size_t n) {
    static_assert(std::is_trivially_copyable_v<T>);
    add_section({std::move(name), {}, {reinterpret_cast<const std::uint8_t*>(data), n * sizeof(T)}});
  }
  template <class T>
  void add_value(std::string name, const T& v) {
    add_array(std::move(name), &v, 1);
  }
  /// Writes atomically and durably. Error{io} names the path, the system's reason and leaves the old file untouched.
  void commit(const std::string& path) const;

 private:
  struct Section {
    std::string name;
    std::vector<std::uint8_t> own;        ///< empty where the bytes are the caller's
    std::span<const std::uint8_t> bytes;  ///< of `own` (a moved vector keeps its place) or of the caller
  };
  void add_section(Section section);
  std::vector<Section> sections_;
};

class CheckpointReader {
 public:
  /// Reads and verifies everything before returning. Error{io}: missing, truncated, wrong magic or version, checksum.
  explicit CheckpointReader(const std::string& path);
  /// The same of the bytes of a file; `path` only names it in errors.
  CheckpointReader(std::string path, std::vector<std::uint8_t> bytes);
  bool has(std::string_view name) const;
  std::span<const std::uint8_t> section(std::string_view name) const;  ///< Error{io} if absent
  template <class T, class C>
  void read_array(std::string_view name, C& out) const {
    auto s = section(name);
    if (s.size() % sizeof(T) != 0)
      throw Error(ErrorCode::io, "section '" + std::string(name) + "' has a wrong size", path_);
    out.resize(s.size() / sizeof(T));
    if (!s.empty()) std::memcpy(out.data(), s.data(), s.size());
  }
  template <class T>
  T read_value(std::string_view name) const {
    auto s = section(name);
    if (s.size() != sizeof(T))
      throw Error(ErrorCode::io, "section '" + std::string(name) + "' has a wrong size", path_);
    T v;
    std::memcpy(&v, s.data(), sizeof(T));
    return v;
  }
  const std::string& path() const noexcept { return path_; }
  /// Names of all sections, ascending.
  std::vector<std::string> names() const {
    std::vector<std::string> all;
    for (const auto& entry : sections_) all.push_back(entry.first);
    return all;
  }

 private:
  std::string path_;
  std::vector<std::uint8_t> bytes_;
  std::map<std::string, std::span<const std::uint8_t>, std::less<>> sections_;
};

}  // namespace talus
