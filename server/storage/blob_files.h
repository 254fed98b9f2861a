// Meshes and masks on disk, each in a file named by its content's hash.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "render/scene/blob.h"
#include "render/scene/content_hash.h"

namespace penumbra {

// Any thread may use it, for different blobs at a time.
class BlobFiles {
 public:
  // `folder` is there.
  explicit BlobFiles(std::string folder) : folder_(std::move(folder)) {}

  // Returns once the blob is on disk; at once where it is already.
  // Errors  those of WriteDurably, also of the rest
  absl::Status Write(const ContentHash& hash, const BlobContent& content);

  // The bytes, which may have been damaged: their hash tells. Errors  kNotFound MISSING_BLOB
  absl::StatusOr<std::string> Read(const ContentHash& hash) const;

  absl::Status Remove(const ContentHash& hash);
  // Gives a damaged one another name.
  absl::Status PutAside(const ContentHash& hash);

  // All that are there. What a crash left half written is removed.
  absl::StatusOr<std::vector<ContentHash>> List();

 private:
  std::string FolderOf(const ContentHash& hash) const;
  std::string PathOf(const ContentHash& hash) const;

  const std::string folder_;
};

}  // namespace penumbra
