// What was asked for of those commands that keep scenes, bring them back and compare them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "client/cli/engine_choice.h"

namespace penumbra {

struct ScenesListCommand {
  EngineChoice engine;
  bool json = false;
};

struct ScenesExportCommand {
  EngineChoice engine;
  std::string scene_id;
  std::filesystem::path file;
  bool without_history = false;
  bool json = false;
};

struct ScenesImportCommand {
  EngineChoice engine;
  std::filesystem::path file;
  std::string scene_id;  // empty: the archive's own
  bool json = false;
};

struct ScenesDeleteCommand {
  EngineChoice engine;
  std::vector<std::string> scene_ids;
};

struct ScenesDiffCommand {
  EngineChoice engine;  // of scenes that are no files
  std::string from;     // a file's name, or a scene's id
  std::string to;
  bool json = false;
};

struct ReplayCommand {
  EngineChoice engine;
  std::filesystem::path archive;
  std::string scene_id;           // of the server's; empty: one for the time being
  std::optional<uint64_t> until;  // the last revision; absent: the archive's
  double speed = 0.0;             // times as fast as it was made; 0: without waiting
  bool json = false;
};

}  // namespace penumbra
