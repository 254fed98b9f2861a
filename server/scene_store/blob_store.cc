#include "server/scene_store/blob_store.h"

#include <algorithm>
#include <new>
#include <utility>
#include <variant>

#include "render/scene/field_error.h"

namespace penumbra {
namespace {

// The first allocation of an upload; more comes with the bytes, so that announcing much costs
// nothing.
constexpr uint64_t kFirstAllocation = 1u << 20;

ContentHash HashOf(const BlobContent& content) {
  return std::visit([](const auto& blob) { return blob->id(); }, content);
}

bool IsInUse(const BlobContent& content) {
  return std::visit([](const auto& blob) { return blob.use_count() > 1; }, content);
}

absl::Status Invalid(const char* reason, const char* field, const std::string& text) {
  return FieldError(absl::StatusCode::kInvalidArgument, reason, field, text);
}

// What the limits allow may still be more than the machine has.
absl::Status OutOfMemory(uint64_t size) {
  return FieldError(absl::StatusCode::kResourceExhausted, "OUT_OF_MEMORY", "data",
                    "found too little memory for a blob of " + std::to_string(size) +
                        " bytes, need a smaller one or less in the store");
}

absl::Status DamagedBlob(const ContentHash& hash) {
  return FieldError(absl::StatusCode::kDataLoss, "DAMAGED", "blob",
                    "found other content than that of " + hash.hex() + ", need it as it was");
}

absl::Status OverQuota(const char* what, uint64_t found, uint64_t limit) {
  return FieldError(absl::StatusCode::kResourceExhausted, "QUOTA_BLOB_BYTES", "header.size_bytes",
                    "found " + std::to_string(found) + ", need at most " + std::to_string(limit) +
                        " bytes " + what);
}

}  // namespace

BlobStore::BlobStore(const ServerLimits& limits, Clock now)
    : limits_(limits), now_(std::move(now)) {}

absl::StatusOr<std::unique_ptr<BlobStore::Upload>> BlobStore::Begin(const ContentHash& hash,
                                                                    uint64_t size_bytes,
                                                                    const BlobOwner& owner) {
  if (size_bytes == 0) {
    return Invalid("LENGTH", "header.size_bytes", "found 0, need the number of bytes");
  }
  if (size_bytes > limits_.max_blob_bytes) {
    return OverQuota("in one blob", size_bytes, limits_.max_blob_bytes);
  }
  std::lock_guard lock(mutex_);
  MakeRoom(size_bytes);
  if (bytes_ + size_bytes > limits_.max_blob_store_bytes) {
    return OverQuota("in all blobs together", bytes_ + size_bytes, limits_.max_blob_store_bytes);
  }
  const auto found = bytes_of_.find(owner.name);
  const uint64_t theirs = size_bytes + (found == bytes_of_.end() ? 0 : found->second);
  if (owner.max_bytes > 0 && theirs > owner.max_bytes) {
    return OverQuota("in all blobs of the same owner", theirs, owner.max_bytes);
  }
  Count(size_bytes, owner.name);
  return std::unique_ptr<Upload>(new Upload(*this, hash, size_bytes, owner.name));
}

BlobStore::Upload::~Upload() { store_.GiveBack(size_, owner_); }

void BlobStore::Attribute(const ContentHash& hash, const std::string& owner) {
  std::lock_guard lock(mutex_);
  const auto entry = entries_.find(hash);
  if (entry == entries_.end() || !entry->second.owner.empty()) return;
  entry->second.owner = owner;
  bytes_ -= entry->second.bytes;
  Count(entry->second.bytes, owner);
}

void BlobStore::Count(uint64_t bytes, const std::string& owner) {
  bytes_ += bytes;
  if (!owner.empty()) bytes_of_[owner] += bytes;
}

void BlobStore::Discount(uint64_t bytes, const std::string& owner) {
  bytes_ -= bytes;
  const auto theirs = bytes_of_.find(owner);
  if (theirs == bytes_of_.end()) return;
  theirs->second -= bytes;
  if (theirs->second == 0) bytes_of_.erase(theirs);
}

uint64_t BlobStore::BytesOf(const std::string& owner) const {
  std::lock_guard lock(mutex_);
  const auto theirs = bytes_of_.find(owner);
  return theirs == bytes_of_.end() ? 0 : theirs->second;
}

absl::Status BlobStore::Upload::Append(const std::string& data) {
  if (data.size() > size_ - bytes_.size()) {
    return Invalid("LENGTH", "data",
                   "found " + std::to_string(bytes_.size() + data.size()) +
                       " bytes, need the announced " + std::to_string(size_));
  }
  const auto* begin = reinterpret_cast<const std::byte*>(data.data());
  try {
    if (bytes_.empty()) bytes_.reserve(std::min(size_, kFirstAllocation));
    bytes_.insert(bytes_.end(), begin, begin + data.size());
  } catch (const std::bad_alloc&) {
    return OutOfMemory(size_);
  }
  return absl::OkStatus();
}

absl::StatusOr<BlobContent> BlobStore::Upload::Finish() {
  if (!is_complete()) {
    return Invalid("LENGTH", "data",
                   "found " + std::to_string(bytes_.size()) + " bytes, need the announced " +
                       std::to_string(size_));
  }
  try {
    return Decode();
  } catch (const std::bad_alloc&) {
    return OutOfMemory(size_);
  }
}

absl::StatusOr<BlobContent> BlobStore::Upload::Decode() {
  auto content = DecodeBlob(bytes_, store_.limits_.scene);
  if (!content.ok()) return content.status();
  std::vector<std::byte>().swap(bytes_);
  if (const ContentHash found = HashOf(*content); found != hash_) {
    return Invalid("HASH_MISMATCH", "header.hash",
                   "found " + hash_.hex() + ", need that of the content, " + found.hex());
  }
  if (auto status = store_.Store(hash_, size_, owner_, *content); !status.ok()) return status;
  return content;
}

absl::Status BlobStore::Store(const ContentHash& hash, uint64_t bytes, const std::string& owner,
                              BlobContent content) {
  if (!files_) {
    Keep(hash, bytes, owner, std::move(content));
    return absl::OkStatus();
  }
  std::lock_guard lock(files_mutex_);
  if (auto status = files_->Write(hash, content); !status.ok()) return status;
  Keep(hash, bytes, owner, std::move(content));
  return absl::OkStatus();
}

absl::Status BlobStore::Load(const ContentHash& hash) {
  const auto bytes = files_->Read(hash);
  if (!bytes.ok()) return bytes.status();
  auto upload = Begin(hash, bytes->size());
  if (!upload.ok()) return upload.status();
  if (auto status = (*upload)->Append(*bytes); !status.ok()) return status;
  const absl::Status status = (*upload)->Finish().status();
  if (!absl::IsInvalidArgument(status)) return status;
  files_->PutAside(hash).IgnoreError();
  return DamagedBlob(hash);
}

absl::StatusOr<BlobContent> BlobStore::Fetch(const ContentHash& hash) const {
  if (auto here = FindBlob(hash)) return *std::move(here);
  if (!files_) {
    return FieldError(absl::StatusCode::kNotFound, "MISSING_BLOB", "blob",
                      "found no " + hash.hex() + ", need it");
  }
  const auto bytes = files_->Read(hash);
  if (!bytes.ok()) return bytes.status();
  auto content = DecodeBlob(std::as_bytes(std::span(*bytes)), limits_.scene);
  if (!content.ok() || HashOf(*content) != hash) return DamagedBlob(hash);
  return content;
}

absl::StatusOr<std::vector<ContentHash>> BlobStore::DropUnused(std::chrono::seconds age) {
  {
    std::lock_guard lock(mutex_);
    const auto kept_since = now_() - age;
    absl::erase_if(entries_, [&](const auto& item) {
      const bool is_dropped = item.second.used < kept_since && !IsInUse(item.second.content);
      if (is_dropped) Discount(item.second.bytes, item.second.owner);
      return is_dropped;
    });
  }
  if (!files_) return std::vector<ContentHash>();
  auto hashes = files_->List();
  if (hashes.ok()) std::erase_if(*hashes, [this](const auto& hash) { return Holds(hash); });
  return hashes;
}

absl::Status BlobStore::RemoveFiles(std::span<const ContentHash> hashes) {
  for (const ContentHash& hash : hashes) {
    // With the lock: an upload of it may be about to find that the file is there.
    std::lock_guard lock(files_mutex_);
    if (Holds(hash)) continue;
    if (auto status = files_->Remove(hash); !status.ok()) return status;
  }
  return absl::OkStatus();
}

bool BlobStore::Holds(const ContentHash& hash) const {
  std::lock_guard lock(mutex_);
  return entries_.contains(hash);
}

void BlobStore::Keep(const ContentHash& hash, uint64_t bytes, const std::string& owner,
                     BlobContent content) {
  std::lock_guard lock(mutex_);
  const auto [entry, is_new] = entries_.try_emplace(hash);
  entry->second.used = now_();
  if (!is_new) return;
  entry->second.content = std::move(content);
  entry->second.bytes = bytes;
  entry->second.owner = owner;
  Count(bytes, owner);  // its own: the upload's go back when that ends
}

void BlobStore::GiveBack(uint64_t bytes, const std::string& owner) {
  std::lock_guard lock(mutex_);
  Discount(bytes, owner);
}

void BlobStore::MakeRoom(uint64_t bytes) {
  if (bytes_ + bytes <= limits_.max_blob_store_bytes) return;
  const auto kept_since = now_() - limits_.unused_blob_lifetime;
  std::vector<std::pair<std::chrono::steady_clock::time_point, ContentHash>> unused;
  for (const auto& [hash, entry] : entries_) {
    if (entry.used < kept_since && !IsInUse(entry.content)) unused.emplace_back(entry.used, hash);
  }
  std::sort(unused.begin(), unused.end());
  for (const auto& [used, hash] : unused) {
    if (bytes_ + bytes <= limits_.max_blob_store_bytes) return;
    const auto entry = entries_.find(hash);
    Discount(entry->second.bytes, entry->second.owner);
    entries_.erase(entry);
  }
}

const BlobStore::Entry* BlobStore::Find(const ContentHash& hash) const {
  const auto entry = entries_.find(hash);
  if (entry == entries_.end()) return nullptr;
  entry->second.used = now_();
  return &entry->second;
}

bool BlobStore::Contains(const ContentHash& hash) const {
  std::lock_guard lock(mutex_);
  return Find(hash) != nullptr;
}

std::shared_ptr<const Mesh> BlobStore::FindMesh(const ContentHash& hash) const {
  std::lock_guard lock(mutex_);
  const Entry* entry = Find(hash);
  const auto* mesh = entry ? std::get_if<std::shared_ptr<const Mesh>>(&entry->content) : nullptr;
  return mesh ? *mesh : nullptr;
}

std::shared_ptr<const AlphaMask> BlobStore::FindMask(const ContentHash& hash) const {
  std::lock_guard lock(mutex_);
  const Entry* entry = Find(hash);
  const auto* mask =
      entry ? std::get_if<std::shared_ptr<const AlphaMask>>(&entry->content) : nullptr;
  return mask ? *mask : nullptr;
}

std::optional<BlobContent> BlobStore::FindBlob(const ContentHash& hash) const {
  std::lock_guard lock(mutex_);
  const Entry* entry = Find(hash);
  return entry ? std::optional(entry->content) : std::nullopt;
}

size_t BlobStore::blob_count() const {
  std::lock_guard lock(mutex_);
  return entries_.size();
}

uint64_t BlobStore::blob_bytes() const {
  std::lock_guard lock(mutex_);
  return bytes_;
}

size_t DegenerateTriangleCount(const BlobContent& content) {
  const auto* mesh = std::get_if<std::shared_ptr<const Mesh>>(&content);
  return mesh ? (*mesh)->degenerate_triangle_count() : 0;
}

}  // namespace penumbra
