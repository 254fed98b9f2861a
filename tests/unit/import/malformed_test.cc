// Damaged files of other projects' test suites, beside which the Khronos validator's reports lie.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "client/import/import_scene.h"
#include "render/scene/field_error.h"
#include "tests/unit/import/third_party_scenes.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;
using MalformedTest = ThirdPartyScenes;

std::vector<fs::path> MalformedFiles() {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(ScenesFolder() / "malformed")) {
    const std::string extension = entry.path().extension().string();
    if (extension == ".gltf" || extension == ".glb" || extension == ".obj" || extension == ".ply") {
      files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

// The validator's codes of severity "error"; empty where there is no report.
std::vector<std::string> ValidatorErrors(const fs::path& file) {
  std::ifstream stream(file.string() + ".report.json");
  const auto report = nlohmann::json::parse(stream, nullptr, false);
  std::vector<std::string> codes;
  if (!report.is_object()) return codes;
  for (const auto& message : report["issues"]["messages"]) {
    if (message["severity"] == 0) codes.push_back(message["code"]);
  }
  return codes;
}

TEST_F(MalformedTest, EveryFileIsReadOrRefusedByName) {
  size_t refused = 0;
  for (const fs::path& file : MalformedFiles()) {
    const auto scene = ImportScene(file);
    if (scene.ok()) {
      EXPECT_TRUE(Scene::Empty("s")->Apply(ToSceneDelta(*scene)).ok()) << file;
      continue;
    }
    ++refused;
    EXPECT_FALSE(ErrorFieldPath(scene.status()).empty()) << file;
    EXPECT_THAT(
        std::string(scene.status().message()),
        testing::AllOf(testing::StartsWith(file.filename().string()), testing::HasSubstr("need")))
        << file;
  }
  EXPECT_GT(refused, 70u);
}

TEST_F(MalformedTest, ObjNumbersThatAreNotFiniteAreRefused) {
  const auto scene = ImportScene(ScenesFolder() / "malformed/obj-ply/draco/inf_nan.obj");
  EXPECT_EQ(scene.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(scene.status().message()), testing::HasSubstr("line 1: v: found"));
}

// What points to where nothing is must not pass, whether the scene uses it or not.
TEST_F(MalformedTest, WhatPointsNowhereIsRefused) {
  const std::vector<std::string> fatal = {"BUFFER_VIEW_TOO_LONG",
                                          "BUFFER_BYTE_LENGTH_MISMATCH",
                                          "GLB_INVALID_VERSION",
                                          "GLB_LENGTH_MISMATCH",
                                          "GLB_UNEXPECTED_END_OF_CHUNK_DATA",
                                          "GLB_CHUNK_TOO_BIG",
                                          "NODE_LOOP",
                                          "NODE_PARENT_OVERRIDE"};
  size_t checked = 0;
  for (const fs::path& file : MalformedFiles()) {
    const std::vector<std::string> codes = ValidatorErrors(file);
    // Animations are not read, nor a skin's root.
    const std::string where = file.parent_path().filename().string();
    const bool reference = std::count(codes.begin(), codes.end(), "UNRESOLVED_REFERENCE") > 0 &&
                           where != "animation" && file.stem() != "unresolved_skeleton";
    const bool is_fatal =
        reference || std::any_of(codes.begin(), codes.end(), [&fatal](const std::string& code) {
          return std::count(fatal.begin(), fatal.end(), code) > 0;
        });
    if (!is_fatal) continue;
    ++checked;
    EXPECT_FALSE(ImportScene(file).ok()) << file << " " << codes.front();
  }
  EXPECT_GT(checked, 25u);
}

}  // namespace
}  // namespace penumbra
