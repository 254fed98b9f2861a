// What a kill leaves of a folder of scenes, while the server goes on.
//
//   LeaveAsByKill(folder / "data", folder / "copy");
//   if (const auto file = SceneFileIn(folder / "copy", "studio")) Use(file->journal());
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <utility>

#include "server/storage/scene_file.h"

namespace penumbra::testing {

// Makes `copy` what `data` is at this moment.
inline void LeaveAsByKill(const std::string& data, const std::string& copy) {
  std::error_code error;
  for (int i = 0; i < 100; ++i) {
    std::filesystem::remove_all(copy);
    error.clear();
    std::filesystem::copy(data, copy, std::filesystem::copy_options::recursive, error);
    if (!error) return;  // else the server has just renamed or removed a file
  }
  FAIL() << error.message();
}

// The scene's newest file; null: there is none that can be read, or it was just being written.
inline std::unique_ptr<SceneFile> SceneFileIn(const std::string& data, const std::string& id) {
  for (int number = 9; number > 0; --number) {
    const std::string path = data + "/scenes/" + id + "~" + std::to_string(number) + ".db";
    if (!std::filesystem::exists(path)) continue;
    auto file = SceneFile::Open(path, {});
    return file.ok() ? *std::move(file) : nullptr;
  }
  return nullptr;
}

}  // namespace penumbra::testing
