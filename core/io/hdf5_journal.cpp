// See hdf5_journal.hpp. The driver interface is that of H5FDpublic.h; every callback is a plain function.
#include "core/io/hdf5_journal.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <map>
#include <memory>
#include <vector>

namespace talus {
namespace {

constexpr haddr_t k_page = 4096;
constexpr haddr_t k_most = static_cast<haddr_t>(1) << 62;

/// A part of the file as it is to be, and which of its bytes differ from the disk.
struct Page {
  std::array<unsigned char, k_page> bytes{};
  std::size_t from = k_page, to = 0;
};

struct Journal {
  H5FD_t base{};  ///< first: the library takes the object for this
  int fd = -1;
  haddr_t eoa = 0, eof = 0;  ///< as the library sees them
  haddr_t safe = 0;          ///< bytes below may be followed by readers: held back until commit
  std::map<haddr_t, Page> held;
};

Journal& of(H5FD_t* file) { return *reinterpret_cast<Journal*>(file); }
const Journal& of(const H5FD_t* file) { return *reinterpret_cast<const Journal*>(file); }

herr_t failed(const char* action) {
  const int error = errno;
  H5Epush2(H5E_DEFAULT, __FILE__, action, __LINE__, H5E_ERR_CLS, H5E_IO, H5E_WRITEERROR, "%s", std::strerror(error));
  errno = error;
  return -1;
}

bool write_at(int fd, haddr_t at, const unsigned char* data, std::size_t n) {
  while (n > 0) {
    const ssize_t put = pwrite(fd, data, n, static_cast<off_t>(at));
    if (put < 0 && errno == EINTR) continue;
    if (put == 0) errno = EIO;
    if (put <= 0) return false;
    data += put;
    at += static_cast<haddr_t>(put);
    n -= static_cast<std::size_t>(put);
  }
  return true;
}

/// Bytes behind the end read as 0.
bool read_at(int fd, haddr_t at, unsigned char* data, std::size_t n) {
  while (n > 0) {
    const ssize_t got = pread(fd, data, n, static_cast<off_t>(at));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return false;
    if (got == 0) {
      std::memset(data, 0, n);
      return true;
    }
    data += got;
    at += static_cast<haddr_t>(got);
    n -= static_cast<std::size_t>(got);
  }
  return true;
}

bool hold(Journal& j, haddr_t at, const unsigned char* data, std::size_t n) {
  while (n > 0) {
    const haddr_t begin = at / k_page * k_page;
    const std::size_t from = at - begin, part = std::min<std::size_t>(n, k_page - from);
    auto [entry, fresh] = j.held.try_emplace(begin);
    Page& page = entry->second;
    if (fresh && !read_at(j.fd, begin, page.bytes.data(), k_page)) return false;
    std::memcpy(page.bytes.data() + from, data, part);
    page.from = std::min(page.from, from);
    page.to = std::max(page.to, from + part);
    data += part;
    at += part;
    n -= part;
  }
  return true;
}

/// One write per run of neighbouring bytes: a block of the library is changed at once.
bool commit(Journal& j) {
  for (auto page = j.held.begin(); page != j.held.end();) {
    const haddr_t begin = page->first + page->second.from;
    std::vector<unsigned char> run;
    haddr_t end = begin;
    while (page != j.held.end() && page->first + page->second.from == end) {
      const Page& p = page->second;
      run.insert(run.end(), p.bytes.begin() + static_cast<long>(p.from), p.bytes.begin() + static_cast<long>(p.to));
      end = page->first + p.to;
      ++page;
    }
    if (!write_at(j.fd, begin, run.data(), run.size())) return false;
  }
  j.held.clear();
  j.safe = j.eof;
  return true;
}

H5FD_t* open(const char* name, unsigned flags, hid_t, haddr_t) {
  const bool writes = (flags & H5F_ACC_RDWR) != 0;
  int mode = O_CLOEXEC | (writes ? O_RDWR : O_RDONLY);
  if ((flags & H5F_ACC_TRUNC) != 0) mode |= O_TRUNC;
  if ((flags & H5F_ACC_CREAT) != 0) mode |= O_CREAT;
  if ((flags & H5F_ACC_EXCL) != 0) mode |= O_EXCL;
  auto j = std::make_unique<Journal>();
  j->fd = ::open(name, mode, 0666);
  struct stat st = {};
  if (j->fd < 0 || fstat(j->fd, &st) != 0) {
    failed("open");
    if (j->fd >= 0) ::close(j->fd);
    return nullptr;
  }
  j->eof = j->safe = static_cast<haddr_t>(st.st_size);
  return &j.release()->base;
}

herr_t close(H5FD_t* file) {
  const std::unique_ptr<Journal> j(&of(file));
  const bool written = commit(*j);
  const herr_t result = written ? 0 : failed("close");
  ::close(j->fd);
  return result;
}

int compare(const H5FD_t* a, const H5FD_t* b) {
  struct stat s = {}, t = {};
  if (fstat(of(a).fd, &s) != 0 || fstat(of(b).fd, &t) != 0) return a < b ? -1 : 1;
  if (s.st_dev != t.st_dev) return s.st_dev < t.st_dev ? -1 : 1;
  if (s.st_ino != t.st_ino) return s.st_ino < t.st_ino ? -1 : 1;
  return 0;
}

herr_t query(const H5FD_t*, unsigned long* flags) {
  *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE |
           H5FD_FEAT_AGGREGATE_SMALLDATA | H5FD_FEAT_DEFAULT_VFD_COMPATIBLE;
  return 0;
}

haddr_t get_eoa(const H5FD_t* file, H5FD_mem_t) { return of(file).eoa; }
haddr_t get_eof(const H5FD_t* file, H5FD_mem_t) { return of(file).eof; }
herr_t set_eoa(H5FD_t* file, H5FD_mem_t, haddr_t address) {
  of(file).eoa = address;
  return 0;
}
herr_t get_handle(H5FD_t* file, hid_t, void** handle) {
  *handle = file;
  return 0;
}

herr_t read(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t at, std::size_t n, void* to) {
  const Journal& j = of(file);
  auto* bytes = static_cast<unsigned char*>(to);
  if (!read_at(j.fd, at, bytes, n)) return failed("read");
  for (auto page = j.held.lower_bound(at / k_page * k_page); page != j.held.end() && page->first < at + n; ++page) {
    const haddr_t from = std::max(at, page->first + page->second.from);
    const haddr_t end = std::min(at + n, page->first + page->second.to);
    if (from < end) std::memcpy(bytes + (from - at), page->second.bytes.data() + (from - page->first), end - from);
  }
  return 0;
}

herr_t write(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t at, std::size_t n, const void* from) {
  Journal& j = of(file);
  const auto* bytes = static_cast<const unsigned char*>(from);
  const std::size_t below = at < j.safe ? std::min<std::size_t>(n, j.safe - at) : 0;
  if (!hold(j, at, bytes, below) || !write_at(j.fd, at + below, bytes + below, n - below)) return failed("write");
  j.eof = std::max(j.eof, at + n);
  return 0;
}

/// A shorter file has to wait: what is on disk may still refer to its end. The owner cuts it after commit.
herr_t truncate(H5FD_t* file, hid_t, hbool_t) {
  Journal& j = of(file);
  struct stat st = {};
  if (fstat(j.fd, &st) != 0) return failed("stat");
  if (static_cast<haddr_t>(st.st_size) < j.eoa && ftruncate(j.fd, static_cast<off_t>(j.eoa)) != 0)
    return failed("extend");
  j.eof = j.eoa;
  return 0;
}

hid_t driver() {
  static const hid_t id = [] {
    static H5FD_class_t c{};
    static const H5FD_mem_t map[H5FD_MEM_NTYPES] = H5FD_FLMAP_DICHOTOMY;
    c.name = "talus_journal";
    c.maxaddr = k_most;
    c.fc_degree = H5F_CLOSE_WEAK;
    c.open = open;
    c.close = close;
    c.cmp = compare;
    c.query = query;
    c.get_eoa = get_eoa;
    c.set_eoa = set_eoa;
    c.get_eof = get_eof;
    c.get_handle = get_handle;
    c.read = read;
    c.write = write;
    c.truncate = truncate;
    std::copy(std::begin(map), std::end(map), c.fl_map);
    return H5FDregister(&c);
  }();
  return id;
}

}  // namespace

bool use_journal(hid_t access) { return driver() >= 0 && H5Pset_driver(access, driver(), nullptr) >= 0; }

bool commit_journal(hid_t file) {
  void* handle = nullptr;
  if (H5Fget_vfd_handle(file, H5P_DEFAULT, &handle) < 0 || handle == nullptr) {
    errno = EINVAL;
    return false;
  }
  return commit(of(static_cast<H5FD_t*>(handle)));
}

}  // namespace talus
