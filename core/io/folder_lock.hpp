// The lock of a run folder: at most one run writes into it. Who calls it: core/io/run_folder. Invariant: the lock is
// held by the open file (an OFD lock on FOLDER/run.lock), so it vanishes with the process however that ends; the text
// in the file only names the holder. On NFS it needs a lock service on the server (NFS 4 has one); where the file
// system knows no locks, the run goes on without.
#pragma once

#include <string>

namespace talus {

class FolderLock {
 public:
  static constexpr const char* k_file = "run.lock";
  /// Takes the lock of a folder that exists. Error{io}: another process holds it (its pid and host are named), or the
  /// file cannot be opened.
  explicit FolderLock(const std::string& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;
  /// "pid 12 on host a" of the process that holds the lock of `folder`; empty if none does, or none can be told.
  static std::string holder(const std::string& folder);

 private:
  int fd_ = -1;
};

}  // namespace talus
