// What was computed, as files that may go at any time: each named by a hash, all together within a
// bound, the ones unused for longest going first.
//
// A crash, or a disk without room, loses such a file, and nothing but it: what is in one is read
// only if its bytes have the hash that was written with them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "render/scene/content_hash.h"

namespace penumbra {

// Any thread may use it, any number at a time.
class ResultFiles {
 public:
  // No file takes more than this part of the bound.
  static constexpr uint64_t kLargestPart = 4;
  // What is left of a disk for what must not be lost.
  static constexpr uint64_t kReserve = uint64_t{512} << 20;

  // Makes the folder, in one that is there. Removes what a crash has left half written, and what is
  // over the bound. Other files in it are let alone.
  // Errors  kUnavailable STORAGE_FAILED
  static absl::StatusOr<std::unique_ptr<ResultFiles>> Open(const std::string& folder,
                                                           uint64_t max_bytes);

  // nullopt: there is none, or a damaged one, which is removed.
  std::optional<std::string> Read(const ContentHash& name);
  // Does nothing where there is one of this name, or where it would be too large. Where the disk
  // has less than kReserve left, the files that were unused for longest go instead. Does not wait
  // for the disk to have it.
  // Errors  kResourceExhausted DISK_FULL; kUnavailable STORAGE_FAILED
  absl::Status Write(const ContentHash& name, std::string_view bytes);

  void Remove(const ContentHash& name);
  bool Contains(const ContentHash& name) const;
  // Of all files.
  uint64_t bytes() const;

 private:
  struct File {
    ContentHash name;
    uint64_t bytes;
  };
  using Files = std::list<File>;

  ResultFiles(std::string folder, uint64_t max_bytes)
      : folder_(std::move(folder)), max_bytes_(max_bytes) {}
  std::string PathOf(const ContentHash& name) const { return folder_ + "/" + name.hex(); }
  absl::Status Find();
  uint64_t MissingReserve() const;
  // The lock is held. What is to be removed comes off the list first, and off the disk without it.
  void Add(const ContentHash& name, uint64_t bytes);
  Files TakeOut(uint64_t bytes);
  Files TakeOut(const ContentHash& name);
  void Unlink(const Files& files) const;

  const std::string folder_;
  const uint64_t max_bytes_;
  mutable std::mutex mutex_;
  Files files_;  // the one used last first
  std::map<ContentHash, Files::iterator> by_name_;
  uint64_t bytes_ = 0;
};

}  // namespace penumbra
