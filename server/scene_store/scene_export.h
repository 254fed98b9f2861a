// A scene as the records of an archive, a message's worth at a time, while its edits go on.
//
//   v1::ExportSceneResponse message;
//   bool is_there_more = *(*exported)->Next(max_bytes, message);
//
// All of it is of one revision. The history is read where it lies, and is not compacted meanwhile;
// blobs are read one after another.
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "penumbra/v1/archive.pb.h"
#include "render/scene/blob.h"
#include "server/scene_store/blob_store.h"
#include "server/scene_store/scene_log.h"

namespace penumbra {

class SceneExport {
 public:
  // With the history that `log` has. Errors, of all three  those of SceneLog; kDataLoss DAMAGED;
  // kNotFound MISSING_BLOB: what the history names; kAborted: the history was begun anew after an
  // error of the disk, export it again
  static absl::StatusOr<std::unique_ptr<SceneExport>> OfHistory(std::shared_ptr<SceneLog> log,
                                                                const BlobStore& blobs,
                                                                size_t max_message_bytes);
  // `scene` alone, which is held until then, and with it its blobs.
  static absl::StatusOr<std::unique_ptr<SceneExport>> OfScene(std::shared_ptr<const Scene> scene,
                                                              const std::string& incarnation,
                                                              const BlobStore& blobs,
                                                              size_t max_message_bytes);
  ~SceneExport();

  // Fills an empty message; false once the end is in it. Waits for the disk. At first it looks
  // through the history for the blobs that have to come before it, a piece a call, and until the
  // last of them leaves the message empty.
  absl::StatusOr<bool> Next(v1::ExportSceneResponse& message);

 private:
  enum class Stage { kSearch, kHead, kBlobs, kBase, kCommits, kEnd, kOver };

  SceneExport(const BlobStore& blobs, size_t max_message_bytes)
      : blobs_(blobs), max_message_bytes_(max_message_bytes) {}
  absl::Status ReadBase();
  absl::Status SearchBase();
  absl::Status SearchOn();
  absl::StatusOr<bool> AddRecord(v1::ExportSceneResponse& message);
  // These add one record, or find that their stage is over.
  absl::Status AddBlob(v1::ExportSceneResponse& message);
  absl::Status AddCommit(v1::ExportSceneResponse& message);
  void AddBase(v1::ExportSceneResponse& message);
  void AddBytes(v1::ArchiveRecord& record);

  const BlobStore& blobs_;
  const size_t max_message_bytes_;
  std::shared_ptr<SceneLog> log_;       // pinned; null: no history
  std::shared_ptr<const Scene> scene_;  // where there is none
  Stage stage_ = Stage::kSearch;
  size_t room_ = 0;  // in the message that is being filled, for bytes
  v1::ArchiveHead head_;
  Revision searched_ = 0;        // up to here it is known what blobs are named
  std::set<ContentHash> named_;  // until all of them are
  std::deque<ContentHash> blobs_left_;
  std::deque<v1::ArchiveBase> base_left_;
  std::deque<CommitRecord> commits_read_;
  Revision revision_ = 0;  // of the last commit read, or the base
  ContentHash chain_;      // of the last commit added, or the base
  // What has begun and whose bytes are to follow; either of the two.
  std::optional<EncodedBlob> blob_;
  std::optional<std::string> delta_;
  size_t bytes_sent_ = 0;  // of it
};

}  // namespace penumbra
