// Archives of scenes between a server and files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/session/archive_options.h"
#include "client/session/scene_archive.h"
#include "render/engine/engine.h"

namespace penumbra {

class ServerConnection;

// What RemoteEngine::ExportScene and ImportScene do; their errors stand there.
class ArchiveTransfer {
 public:
  ArchiveTransfer(ServerConnection& connection, const ArchiveOptions& options)
      : connection_(connection), options_(options) {}

  absl::Status Export(const std::string& scene_id, const std::filesystem::path& file);
  absl::StatusOr<SceneInfo> Import(const std::filesystem::path& file, const std::string& scene_id);

 private:
  absl::Status Upload(const std::filesystem::path& file, const std::vector<ContentHash>& missing,
                      uint64_t bytes);
  absl::StatusOr<SceneInfo> Send(const std::filesystem::path& file, const std::string& scene_id,
                                 uint64_t bytes);
  absl::Status EndOf(const std::filesystem::path& file, const absl::Status& status) const;
  void Show(uint64_t moved, uint64_t total) const;

  ServerConnection& connection_;
  const ArchiveOptions& options_;
};

}  // namespace penumbra
