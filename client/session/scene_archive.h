// An archive of a scene as a file: what it holds, revision by revision.
//
//   auto info = ReadArchive("studio.penumbra", {.on_change = [](const ArchivedChange& change) {
//     …change.delta makes change.scene of the scene before…
//     return absl::OkStatus();
//   }});
//
// Everything that is read has been held against the archive's hashes before it is told.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "render/scene/scene.h"

namespace penumbra {

struct ArchivedBlobName {
  ContentHash hash;
  uint64_t size_bytes = 0;
};

struct ArchiveInfo {
  std::string scene_id;        // where it was exported
  Revision base_revision = 0;  // at which the history begins
  Revision revision = 0;       // the newest
  std::string server_name;     // that made it
  int64_t time_ms = 0;         // since 1970, UTC
  uint64_t file_bytes = 0;
  std::vector<ArchivedBlobName> blobs;
  std::shared_ptr<const Scene> scene;  // at the newest revision
};

struct ArchivedChange {
  const SceneDelta& delta;
  const std::shared_ptr<const Scene>& scene;  // after it; its content hash is the archive's
  const std::string& author;
  int64_t time_ms = 0;
};

// Either may be null. An error of theirs ends the reading with that error.
struct ArchiveVisitor {
  // The scene where the history begins; empty at revision 0.
  std::function<absl::Status(const std::shared_ptr<const Scene>&)> on_base = nullptr;
  std::function<absl::Status(const ArchivedChange&)> on_change = nullptr;
  std::stop_token stop = {};
};

// Errors  kNotFound, kInvalidArgument ARCHIVE_FORMAT, kFailedPrecondition VERSION: no file, no
//         archive, or one of a newer format; kDataLoss DAMAGED: the file was cut or changed;
//         kInvalidArgument: what it says does not fit together; kCancelled: stopped. All name the
//         file, and of the last two kinds the byte.
absl::StatusOr<ArchiveInfo> ReadArchive(const std::filesystem::path& path,
                                        const ArchiveVisitor& visitor = {});

}  // namespace penumbra
