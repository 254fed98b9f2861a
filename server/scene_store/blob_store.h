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
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/status/statusor.h"
#include "proto/convert/scene_convert.h"
#include "render/scene/blob.h"
#include "server/limits.h"
#include "server/storage/blob_files.h"

namespace penumbra {

// On whose account a blob is stored.
struct BlobOwner {
  std::string name;        // empty: nobody's
  uint64_t max_bytes = 0;  // of all that is theirs; 0: as much as there is room for
};

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
    Upload(BlobStore& store, const ContentHash& hash, uint64_t size, std::string owner)
        : store_(store), hash_(hash), size_(size), owner_(std::move(owner)) {}

    BlobStore& store_;
    const ContentHash hash_;
    const uint64_t size_;  // reserved in the store while this lives
    const std::string owner_;
    std::vector<std::byte> bytes_;
  };

  // A blob counts for who uploaded it first, as long as it is here.
  // Errors  kInvalidArgument LENGTH: size 0; kResourceExhausted QUOTA_BLOB_BYTES: one blob, the
  //         owner's, or the store after everything unused has been dropped
  absl::StatusOr<std::unique_ptr<Upload>> Begin(const ContentHash& hash, uint64_t size_bytes,
                                                const BlobOwner& owner = {});
  // The blob is the owner's if it is nobody's yet.
  void Attribute(const ContentHash& hash, const std::string& owner);

  // Takes a blob in from disk. Errors  kNotFound MISSING_BLOB; kDataLoss DAMAGED: it is put aside
  //         then, so that it can be uploaded again; those of Begin and Finish
  absl::Status Load(const ContentHash& hash);

  // Drops from memory what no scene has used for `age`; which blobs are on disk alone then.
  // Errors  those of BlobFiles
  absl::StatusOr<std::vector<ContentHash>> DropUnused(std::chrono::seconds age);
  // Removes those of the blobs that are still on disk alone. Errors  those of BlobFiles
  absl::Status RemoveFiles(std::span<const ContentHash> hashes);

  bool Contains(const ContentHash& hash) const;
  bool keeps_on_disk() const { return files_ != nullptr; }
  std::shared_ptr<const Mesh> FindMesh(const ContentHash& hash) const override;
  std::shared_ptr<const AlphaMask> FindMask(const ContentHash& hash) const override;

  // What FindBlob finds, or what is on disk alone, which is not put here.
  // Errors  kNotFound MISSING_BLOB; kDataLoss DAMAGED; those of BlobFiles
  absl::StatusOr<BlobContent> Fetch(const ContentHash& hash) const;
  // Whatever it is. It stays here, and is counted, as long as somebody holds it.
  std::optional<BlobContent> FindBlob(const ContentHash& hash) const;

  size_t blob_count() const;
  uint64_t blob_bytes() const;  // uploads in progress included
  uint64_t BytesOf(const std::string& owner) const;

 private:
  struct Entry {
    BlobContent content;
    uint64_t bytes = 0;
    std::chrono::steady_clock::time_point used;
    std::string owner;  // empty: nobody
  };

  const Entry* Find(const ContentHash& hash) const;
  // Drops the least recently used of what no scene uses, until `bytes` more fit or nothing is left.
  void MakeRoom(uint64_t bytes);
  absl::Status Store(const ContentHash& hash, uint64_t bytes, const std::string& owner,
                     BlobContent content);
  void Keep(const ContentHash& hash, uint64_t bytes, const std::string& owner, BlobContent content);
  bool Holds(const ContentHash& hash) const;  // without a use of it
  void GiveBack(uint64_t bytes, const std::string& owner);
  // With the lock held, as for the next.
  void Count(uint64_t bytes, const std::string& owner);
  void Discount(uint64_t bytes, const std::string& owner);

  const ServerLimits limits_;
  const Clock now_;
  BlobFiles* files_ = nullptr;  // null: in memory only
  std::mutex files_mutex_;      // between a file and what memory says of it; taken before mutex_
  mutable std::mutex mutex_;
  mutable absl::flat_hash_map<ContentHash, Entry> entries_;
  uint64_t bytes_ = 0;
  std::map<std::string, uint64_t> bytes_of_;  // by owner
};

// Triangles of no area; 0 for masks.
size_t DegenerateTriangleCount(const BlobContent& content);

}  // namespace penumbra
