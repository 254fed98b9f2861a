#include "client/session/blob_transfer.h"

#include <algorithm>
#include <set>
#include <span>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/session/call_status.h"
#include "client/session/message_room.h"
#include "client/session/server_connection.h"
#include "proto/convert/geometry_convert.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

// Large enough that the framing costs nothing, small enough that progress is seen.
constexpr size_t kChunkBytes = 512 * 1024;
constexpr size_t kHashesPerRequest = 1024;
constexpr uint64_t kMaxBlobBytes = uint64_t{1} << 30;

size_t LimitOr(uint64_t told, size_t wanted) {
  return told == 0 ? wanted : static_cast<size_t>(std::min<uint64_t>(told, wanted));
}

size_t ChunkBytes(uint64_t max_message_bytes) {
  if (max_message_bytes == 0) return kChunkBytes;
  return std::min(kChunkBytes, RoomInMessage(max_message_bytes));
}

class FetchedBlobs : public BlobSource {
 public:
  std::shared_ptr<const Mesh> FindMesh(const ContentHash& hash) const override {
    const auto found = meshes.find(hash);
    return found == meshes.end() ? nullptr : found->second;
  }
  std::shared_ptr<const AlphaMask> FindMask(const ContentHash& hash) const override {
    const auto found = masks.find(hash);
    return found == masks.end() ? nullptr : found->second;
  }

  std::map<ContentHash, std::shared_ptr<const Mesh>> meshes;
  std::map<ContentHash, std::shared_ptr<const AlphaMask>> masks;
};

}  // namespace

BlobTransfer::BlobTransfer(ServerConnection& connection, const v1::Limits& limits)
    : connection_(connection),
      scene_limits_(SceneLimitsFromProto(limits)),
      chunk_bytes_(ChunkBytes(limits.max_message_bytes())),
      hashes_per_request_(LimitOr(limits.max_hashes_per_request(), kHashesPerRequest)),
      max_blob_bytes_(LimitOr(limits.max_blob_bytes(), kMaxBlobBytes)) {}

UploadTraffic BlobTransfer::traffic() const {
  return {.blobs_sent = blobs_sent_, .bytes_sent = bytes_sent_, .blobs_known = blobs_known_};
}

absl::Status BlobTransfer::UploadMissing(const SceneDelta& delta, const Scene& known) {
  LocalBlobs blobs;
  for (const Instance& instance : delta.upsert_instances) {
    const auto before = known.FindInstance(instance.id);
    const bool same_mesh = before && before->mesh == instance.mesh;
    if (instance.mesh && !same_mesh) blobs[instance.mesh->id()] = {.mesh = instance.mesh};
    const bool same_mask = before && before->alpha_mask == instance.alpha_mask;
    if (instance.alpha_mask && !same_mask) {
      blobs[instance.alpha_mask->id()] = {.mask = instance.alpha_mask};
    }
  }
  if (blobs.empty()) return absl::OkStatus();
  std::vector<ContentHash> hashes;
  for (const auto& [hash, blob] : blobs) {
    Remember(hash, blob);
    hashes.push_back(hash);
  }
  const auto missing = FindMissing(hashes);
  if (!missing.ok()) return missing.status();
  blobs_known_ += blobs.size() - missing->size();
  return missing->empty() ? absl::OkStatus() : Upload(blobs, *missing);
}

absl::StatusOr<std::vector<ContentHash>> BlobTransfer::FindMissing(
    std::span<const ContentHash> hashes) {
  const std::set<ContentHash> asked(hashes.begin(), hashes.end());
  std::vector<ContentHash> missing;
  while (!hashes.empty()) {
    const auto some = hashes.first(std::min(hashes.size(), hashes_per_request_));
    hashes = hashes.subspan(some.size());
    v1::FindMissingBlobsRequest request;
    for (const ContentHash& hash : some) request.add_hashes(ToProto(hash));
    v1::FindMissingBlobsResponse response;
    const absl::Status status =
        connection_.Call(&v1::PenumbraService::Stub::FindMissingBlobs, request, &response);
    if (!status.ok()) return status;
    for (const std::string& bytes : response.missing_hashes()) {
      const auto hash = HashFromProto(bytes, "missing_hashes");
      if (!hash.ok()) return hash.status();
      if (asked.contains(*hash)) missing.push_back(*hash);
    }
  }
  return missing;
}

absl::Status BlobTransfer::Upload(const LocalBlobs& blobs,
                                  const std::vector<ContentHash>& missing) {
  const auto encode = [&](const ContentHash& hash) {
    const Local& blob = blobs.at(hash);
    return blob.mesh ? EncodeBlob(blob.mesh->geometry()) : EncodeBlob(*blob.mask);
  };
  // Encoded twice rather than kept all at once: it costs less than sending.
  uint64_t total = 0;
  for (const ContentHash& hash : missing) total += encode(hash).size();

  grpc::ClientContext context;
  connection_.Prepare(context, total);
  v1::UploadBlobResponse response;
  const auto writer = connection_.stub().UploadBlob(&context, &response);
  uint64_t sent = 0;
  bool is_open = true;
  for (size_t i = 0; i < missing.size() && is_open; ++i) {
    const std::vector<std::byte> bytes = encode(missing[i]);
    for (size_t start = 0; start < bytes.size() && is_open; start += chunk_bytes_) {
      v1::UploadBlobRequest request;
      if (start == 0) {
        request.mutable_header()->set_hash(ToProto(missing[i]));
        request.mutable_header()->set_size_bytes(bytes.size());
      }
      const size_t size = std::min(chunk_bytes_, bytes.size() - start);
      request.set_data(bytes.data() + start, size);
      is_open = writer->Write(request);
      sent += size;
      if (connection_.options().upload_progress) {
        connection_.options().upload_progress(sent, total);
      }
    }
  }
  writer->WritesDone();
  const absl::Status status = StatusOfCall(connection_.options().address, writer->Finish());
  if (!status.ok()) return status;
  blobs_sent_ += missing.size();
  bytes_sent_ += total;
  return absl::OkStatus();
}

absl::StatusOr<std::unique_ptr<BlobSource>> BlobTransfer::Fetch(const v1::SceneDelta& delta,
                                                                std::stop_token stop) {
  auto source = std::make_unique<FetchedBlobs>();
  const auto find = [&](const std::string& bytes, const char* field) -> absl::Status {
    if (bytes.empty()) return absl::OkStatus();
    const auto hash = HashFromProto(bytes, field);
    if (!hash.ok()) return hash.status();
    if (source->meshes.contains(*hash) || source->masks.contains(*hash)) return absl::OkStatus();
    Local blob = Recall(*hash);
    if (!blob.mesh && !blob.mask) {
      auto content = Download(*hash, stop);
      if (!content.ok()) return content.status();
      if (auto* mesh = std::get_if<std::shared_ptr<const Mesh>>(&*content)) blob.mesh = *mesh;
      if (auto* mask = std::get_if<std::shared_ptr<const AlphaMask>>(&*content)) blob.mask = *mask;
      Remember(*hash, blob);
    }
    if (blob.mesh) source->meshes[*hash] = blob.mesh;
    if (blob.mask) source->masks[*hash] = blob.mask;
    return absl::OkStatus();
  };
  for (const v1::Instance& instance : delta.upsert_instances()) {
    absl::Status status = find(instance.mesh_hash(), "mesh_hash");
    if (status.ok()) status = find(instance.alpha_mask_hash(), "alpha_mask_hash");
    if (!status.ok()) return status;
  }
  return source;
}

absl::StatusOr<BlobContent> BlobTransfer::Download(const ContentHash& hash, std::stop_token stop) {
  grpc::ClientContext context;
  const std::stop_callback on_stop(std::move(stop), [&context] { context.TryCancel(); });
  connection_.Prepare(context, max_blob_bytes_);
  v1::DownloadBlobRequest request;
  request.set_hash(ToProto(hash));
  const auto reader = connection_.stub().DownloadBlob(&context, request);
  std::string bytes;
  v1::DownloadBlobResponse response;
  while (reader->Read(&response)) {
    if (bytes.size() + response.data().size() > max_blob_bytes_) context.TryCancel();
    bytes += response.data();
  }
  const absl::Status status = StatusOfCall(connection_.options().address, reader->Finish());
  if (!status.ok()) return status;
  auto content = DecodeBlob(std::as_bytes(std::span(bytes)), scene_limits_);
  if (!content.ok()) return content.status();
  const ContentHash found = std::visit([](const auto& blob) { return blob->id(); }, *content);
  if (found != hash) {
    return absl::DataLossError(
        absl::StrCat("blob: found the content of ", found.hex(), ", need ", hash.hex()));
  }
  return content;
}

void BlobTransfer::Remember(const ContentHash& hash, const Local& blob) {
  std::lock_guard lock(mutex_);
  if (remembered_.size() >= forget_at_) {
    std::erase_if(remembered_, [](const auto& entry) {
      return entry.second.mesh.expired() && entry.second.mask.expired();
    });
    forget_at_ = 64 + 2 * remembered_.size();
  }
  remembered_[hash] = {.mesh = blob.mesh, .mask = blob.mask};
}

BlobTransfer::Local BlobTransfer::Recall(const ContentHash& hash) {
  std::lock_guard lock(mutex_);
  const auto found = remembered_.find(hash);
  if (found == remembered_.end()) return {};
  return {.mesh = found->second.mesh.lock(), .mask = found->second.mask.lock()};
}

}  // namespace penumbra
