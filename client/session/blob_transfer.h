// Meshes and alpha masks on their way to the server and back: what is there is not sent again.
//
//   blobs.UploadMissing(delta, *mirror.Applied());   // before a commit
//   auto source = blobs.Fetch(scene_update.delta(), stop);  // before a mirror applies a change
#pragma once

#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <stop_token>
#include <vector>

#include "absl/status/statusor.h"
#include "client/session/traffic.h"
#include "penumbra/v1/scene.pb.h"
#include "proto/convert/scene_convert.h"
#include "render/scene/blob.h"
#include "render/scene/scene.h"

namespace penumbra {

class ServerConnection;

class BlobTransfer {
 public:
  BlobTransfer(ServerConnection& connection, const v1::Limits& limits);

  const SceneLimits& scene_limits() const { return scene_limits_; }
  // Of a blob in one message; blobs in one call.
  size_t chunk_bytes() const { return chunk_bytes_; }
  size_t blobs_per_call() const { return hashes_per_request_; }

  // Uploads the blobs that `delta` names and the server lacks. Those of the same instance of
  // `known` are there and are not even asked for.
  //
  // Errors  kUnavailable; the server's, over its limits for instance
  absl::Status UploadMissing(const SceneDelta& delta, const Scene& known);

  // Which of them the server lacks. Errors  kUnavailable; the server's
  absl::StatusOr<std::vector<ContentHash>> FindMissing(std::span<const ContentHash> hashes);

  // Where the blobs that `delta` names are, fetched from the server where they have not been seen
  // while something still held them.
  //
  // Errors  kUnavailable; kDataLoss: other bytes came than were asked for; kCancelled: stop
  //         requested
  absl::StatusOr<std::unique_ptr<BlobSource>> Fetch(const v1::SceneDelta& delta,
                                                    std::stop_token stop);

  UploadTraffic traffic() const;

 private:
  // Either a mesh or a mask.
  struct Local {
    std::shared_ptr<const Mesh> mesh;
    std::shared_ptr<const AlphaMask> mask;
  };
  using LocalBlobs = std::map<ContentHash, Local>;

  absl::Status Upload(const LocalBlobs& blobs, const std::vector<ContentHash>& missing);
  absl::StatusOr<BlobContent> Download(const ContentHash& hash, std::stop_token stop);
  void Remember(const ContentHash& hash, const Local& blob);
  Local Recall(const ContentHash& hash);

  ServerConnection& connection_;
  const SceneLimits scene_limits_;
  const size_t chunk_bytes_;
  const size_t hashes_per_request_;
  const uint64_t max_blob_bytes_;

  std::atomic<uint64_t> blobs_sent_{0};
  std::atomic<uint64_t> bytes_sent_{0};
  std::atomic<uint64_t> blobs_known_{0};

  struct Remembered {
    std::weak_ptr<const Mesh> mesh;
    std::weak_ptr<const AlphaMask> mask;
  };
  std::mutex mutex_;
  std::map<ContentHash, Remembered> remembered_;
  size_t forget_at_ = 64;  // entries; then those whose blobs are gone are dropped
};

}  // namespace penumbra
