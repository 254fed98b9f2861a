// A file system for SQLite that fails when it is told to, and is the system's otherwise.
//
//   FaultyVfs vfs;                       // options.vfs = vfs.name()
//   vfs.FailAfter(3, FaultyVfs::Call::kSync, SQLITE_IOERR_FSYNC);
#pragma once

#include <sqlite3.h>

#include <atomic>
#include <cstdint>

#include "tests/support/disk_image.h"

namespace penumbra::testing {

// One at a time.
class FaultyVfs {
 public:
  enum class Call { kNone, kAny, kWrite, kSync, kDelete };

  // With a `disk`, which outlives it, that is told of all writes. What is synced then is the disk's
  // business, and no file is synced in truth.
  explicit FaultyVfs(DiskImage* disk = nullptr);
  ~FaultyVfs();
  FaultyVfs(const FaultyVfs&) = delete;
  FaultyVfs& operator=(const FaultyVfs&) = delete;

  const char* name() const;

  // The call of this kind after `calls` more of them fails with `code`, and so do all that follow,
  // until Heal: a disk that is full stays full. A sync that fails `drops` what was to be synced.
  // `part`  a literal: calls for files that have it in their path, and no others
  void FailAfter(int64_t calls, Call kind, int code, const char* part = "");
  void Heal();
  // Calls of the kind since FailAfter that failed.
  int64_t failures() const;

  // From here on writes and syncs do not return, until Heal: a disk that has gone to sleep.
  void Stall();

  // Asked by the files; `path` is null for temporary ones. SQLITE_OK, or what to fail with.
  int Permit(Call kind, const char* path);
  DiskImage* disk() const { return disk_; }

 private:
  DiskImage* const disk_;
  std::atomic<bool> is_stalled_{false};
  std::atomic<Call> kind_{Call::kNone};
  std::atomic<int> code_{SQLITE_OK};
  std::atomic<const char*> part_{""};
  std::atomic<int64_t> left_{0};
  std::atomic<int64_t> failures_{0};
};

}  // namespace penumbra::testing
