// The meshes and masks that clients have uploaded, by content hash: in memory, and on disk where
// the server keeps scenes there.
//
//   auto upload = store.Begin(hash, size_bytes);           // reserves the bytes
//   if (auto status = upload->Append(chunk); !status.ok()) return status;
//   auto stored = upload->Finish();                        // checks content and hash, keeps the
//   blob
//
// Any thread may use a store; an upload belongs to one thread at a time.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/status/statusor.h"
#include "proto/convert/scene_convert.h"
#include "render/scene/blob.h"
#include "server/limits.h"
#include "server/storage/blob_files.h"

namespace penumbra {

class BlobStore : public BlobSource {
 public:
  using Clock = std::function<std::chrono::steady_clock::time_point()>;

  explicit BlobStore(const ServerLimits& limits, Clock now = std::chrono::steady_clock::now);
  // From here on an upload is finished once it is on disk as well. To be called before any.
  void KeepOn(BlobFiles& files) { files_ = &files; }

  class Upload {
   public:
    ~Upload();
    Upload(const Upload&) = delete;
    Upload& operator=(const Upload&) = delete;

    bool is_complete() const { return bytes_.size() == size_; }
    // Errors  kInvalidArgument LENGTH: more than was announced; kResourceExhausted OUT_OF_MEMORY
    absl::Status Append(const std::string& data);
    // Errors  kInvalidArgument LENGTH: less than was announced; HASH_MISMATCH; those of DecodeBlob;
    //         kResourceExhausted OUT_OF_MEMORY, DISK_FULL; kUnavailable STORAGE_FAILED
    absl::StatusOr<BlobContent> Finish();

   private:
    friend class BlobStore;
    absl::StatusOr<BlobContent> Decode();
    Upload(BlobStore& store, const ContentHash& hash, uint64_t size)
        : store_(store), hash_(hash), size_(size) {}

    BlobStore& store_;
    const ContentHash hash_;
    const uint64_t size_;  // reserved in the store while this lives
    std::vector<std::byte> bytes_;
  };

  // Errors  kInvalidArgument LENGTH: size 0; kResourceExhausted QUOTA_BLOB_BYTES: one blob, or the
  //         store after everything unused has been dropped
  absl::StatusOr<std::unique_ptr<Upload>> Begin(const ContentHash& hash, uint64_t size_bytes);

  // Takes a blob in from disk. Errors  kNotFound MISSING_BLOB; kDataLoss DAMAGED: it is put aside
  //         then, so that it can be uploaded again; those of Begin and Finish
  absl::Status Load(const ContentHash& hash);

  // Drops what no scene has used for `age`, from disk too but for what `needed` says is mentioned.
  // The number of those dropped. Errors  those of BlobFiles
  absl::StatusOr<size_t> Collect(std::chrono::seconds age,
                                 const std::function<bool(const ContentHash&)>& needed);

  bool Contains(const ContentHash& hash) const;
  bool keeps_on_disk() const { return files_ != nullptr; }
  std::shared_ptr<const Mesh> FindMesh(const ContentHash& hash) const override;
  std::shared_ptr<const AlphaMask> FindMask(const ContentHash& hash) const override;

  // Whatever it is. It stays here, and is counted, as long as somebody holds it.
  std::optional<BlobContent> FindBlob(const ContentHash& hash) const;

  size_t blob_count() const;
  uint64_t blob_bytes() const;  // uploads in progress included

 private:
  struct Entry {
    BlobContent content;
    uint64_t bytes = 0;
    std::chrono::steady_clock::time_point used;
  };

  const Entry* Find(const ContentHash& hash) const;
  // Drops the least recently used of what no scene uses, until `bytes` more fit or nothing is left.
  void MakeRoom(uint64_t bytes);
  absl::Status Store(const ContentHash& hash, uint64_t bytes, BlobContent content);
  void Keep(const ContentHash& hash, uint64_t bytes, BlobContent content);
  void DropUnused(std::chrono::seconds age);
  bool Holds(const ContentHash& hash) const;  // without a use of it
  void GiveBack(uint64_t bytes);

  const ServerLimits limits_;
  const Clock now_;
  BlobFiles* files_ = nullptr;  // null: in memory only
  std::mutex files_mutex_;      // between a file and what memory says of it; taken before mutex_
  mutable std::mutex mutex_;
  mutable absl::flat_hash_map<ContentHash, Entry> entries_;
  uint64_t bytes_ = 0;
};

// Triangles of no area; 0 for masks.
size_t DegenerateTriangleCount(const BlobContent& content);

}  // namespace penumbra
