// Checkpoint container; layout and guarantees are in checkpoint.hpp. Who calls it: scheduler/ (save and restore of the
// engine). Invariant: every byte of a file is covered by a checksum, and
// no length read from a file is used before it is checked against the bytes that are there.
#include "core/io/checkpoint.hpp"

#include <xxhash.h>

#include <bit>
#include <memory>
#include <utility>

#include "core/io/atomic_file.hpp"

namespace talus {

namespace {

static_assert(std::endian::native == std::endian::little, "checkpoints are little endian");

constexpr std::string_view k_magic = "TALUSCP1";
constexpr std::size_t k_magic_stem = 7;  // "TALUSCP", then one character of version
constexpr std::size_t k_max_name = 0xffff;

struct HashDelete {
  void operator()(XXH3_state_t* s) const noexcept { XXH3_freeState(s); }
};

/// File and running checksum of everything written to it.
class HashedFile {
 public:
  explicit HashedFile(const std::string& path) : file_(path), state_(XXH3_createState()) {
    if (!state_) throw std::bad_alloc();
    XXH3_64bits_reset(state_.get());
  }
  void put(const void* data, std::size_t n) {
    if (n == 0) return;
    XXH3_64bits_update(state_.get(), data, n);
    file_.write(data, n);
  }
  template <class T>
  void value(T v) {
    put(&v, sizeof v);
  }
  void finish() {
    const std::uint64_t total = XXH3_64bits_digest(state_.get());
    file_.write(&total, sizeof total);
    file_.commit();
  }

 private:
  AtomicFile file_;
  std::unique_ptr<XXH3_state_t, HashDelete> state_;
};

/// Bounds-checked cursor over the bytes of a file.
class Cursor {
 public:
  Cursor(std::span<const std::uint8_t> bytes, const std::string& path) : bytes_(bytes), path_(path) {}
  std::span<const std::uint8_t> take(std::uint64_t n, const char* what) {
    if (n > bytes_.size() - at_)
      throw Error(ErrorCode::io,
                  std::string("checkpoint is truncated or damaged at byte ") + std::to_string(at_) + " (" + what + ")",
                  path_, "resume from the previous checkpoint");
    const auto part = bytes_.subspan(at_, static_cast<std::size_t>(n));
    at_ += static_cast<std::size_t>(n);
    return part;
  }
  template <class T>
  T value(const char* what) {
    T v;
    std::memcpy(&v, take(sizeof v, what).data(), sizeof v);
    return v;
  }
  std::size_t at() const noexcept { return at_; }

 private:
  std::span<const std::uint8_t> bytes_;
  const std::string& path_;
  std::size_t at_ = 0;
};

}  // namespace

void CheckpointWriter::add(std::string name, std::vector<std::uint8_t> bytes) {
  const std::span<const std::uint8_t> view(bytes);
  add_section({std::move(name), std::move(bytes), view});
}

void CheckpointWriter::add_section(Section section) {
  const std::string& name = section.name;
  if (name.empty() || name.size() > k_max_name)
    throw Error(ErrorCode::io, "section name must have 1 to 65535 bytes", "checkpoint");
  for (const auto& s : sections_)
    if (s.name == name) throw Error(ErrorCode::io, "section '" + name + "' is added twice", "checkpoint");
  sections_.push_back(std::move(section));
}

void CheckpointWriter::commit(const std::string& path) const {
  HashedFile out(path);
  out.put(k_magic.data(), k_magic.size());
  out.value(static_cast<std::uint32_t>(sections_.size()));
  for (const auto& [name, own, bytes] : sections_) {
    out.value(static_cast<std::uint16_t>(name.size()));
    out.put(name.data(), name.size());
    out.value(static_cast<std::uint64_t>(bytes.size()));
    out.value(static_cast<std::uint64_t>(XXH3_64bits(bytes.data(), bytes.size())));
    out.put(bytes.data(), bytes.size());
  }
  out.finish();
}

CheckpointReader::CheckpointReader(const std::string& path) : CheckpointReader(path, read_file_bytes(path)) {}

CheckpointReader::CheckpointReader(std::string path, std::vector<std::uint8_t> bytes)
    : path_(std::move(path)), bytes_(std::move(bytes)) {
  Cursor in(bytes_, path_);
  const char* cure = "resume from the previous checkpoint";
  const auto magic = in.take(k_magic.size(), "magic");
  if (std::memcmp(magic.data(), k_magic.data(), k_magic_stem) != 0)
    throw Error(ErrorCode::io, "is not a Talus checkpoint (wrong magic)", path_, "give a file named *.tcp");
  if (magic[k_magic_stem] != static_cast<std::uint8_t>(k_magic[k_magic_stem]))
    throw Error(ErrorCode::io, "checkpoint of another format version; this program reads version 1", path_,
                "use the program that wrote it");
  const auto count = in.value<std::uint32_t>("section count");
  for (std::uint32_t s = 0; s < count; ++s) {
    const auto length = in.value<std::uint16_t>("name length");
    const auto raw = in.take(length, "name");
    std::string name(reinterpret_cast<const char*>(raw.data()), raw.size());
    const auto size = in.value<std::uint64_t>("section size");
    const auto sum = in.value<std::uint64_t>("section checksum");
    const auto body = in.take(size, "section");
    if (XXH3_64bits(body.data(), body.size()) != sum)
      throw Error(ErrorCode::io, "section " + std::to_string(s) + " of the checkpoint is damaged (checksum)", path_,
                  cure);
    if (!sections_.emplace(std::move(name), body).second)
      throw Error(ErrorCode::io, "section " + std::to_string(s) + " of the checkpoint appears twice", path_, cure);
  }
  const std::size_t end = in.at();
  const auto total = in.value<std::uint64_t>("checksum");
  if (in.at() != bytes_.size())
    throw Error(ErrorCode::io, "checkpoint has " + std::to_string(bytes_.size() - in.at()) + " bytes too many", path_,
                cure);
  if (XXH3_64bits(bytes_.data(), end) != total)
    throw Error(ErrorCode::io, "checkpoint is damaged (checksum of the file)", path_, cure);
}

bool CheckpointReader::has(std::string_view name) const { return sections_.find(name) != sections_.end(); }

std::span<const std::uint8_t> CheckpointReader::section(std::string_view name) const {
  const auto it = sections_.find(name);
  if (it == sections_.end())
    throw Error(ErrorCode::io, "checkpoint has no section '" + std::string(name) + "'", path_,
                "it was written for another scene or by another version");
  return it->second;
}

}  // namespace talus
