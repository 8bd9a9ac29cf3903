// The files below the HDF5 library, written so that a kill at any moment, or a write that fails, leaves a file that can
// be read: what the library writes over bytes that readers may follow is kept in memory and goes to disk at commit(),
// in one burst, after everything that it refers to. Who calls it: core/io/vtkhdf. Invariant: before commit() the file
// on disk is the one of the last commit with unused bytes behind it. The format is that of the library's default
// driver.
#pragma once

#include <hdf5.h>

namespace talus {

/// Files opened with these access properties go through here. False on failure.
bool use_journal(hid_t access);
/// After H5Fflush: writes what was held back, by ascending address: superblock first, roots of trees before their
/// leaves. False with errno set on failure.
bool commit_journal(hid_t file);

}  // namespace talus
