// Files of scenes that somebody hands to an importer: glTF, its binary form with lengths that are
// right, OBJ with its materials, and PLY. What is taken is the same each time, has ids and cameras
// that can be used, and is a scene, or refused as one by name.

#include <cmath>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client/import/import_scene.h"
#include "render/scene/scene.h"
#include "tests/fuzz/kit/put_word.h"
#include "tests/fuzz/kit/require.h"
#include "tests/fuzz/kit/target.h"
#include "tests/fuzz/targets/scene_rules.h"
#include "tests/fuzz/targets/scratch_file.h"
#include "tests/fuzz/targets/small_studio.h"
#include "tests/support/temporary_folder.h"

namespace penumbra::fuzzing {
namespace {

// The JSON of a .gltf, or of a .glb whose bytes are those of the last buffer; OBJ, PLY; a file of
// whichever kind its first bytes say. Buffers and materials are what the others name.
enum Kind : uint8_t { kGltf, kGlb, kObj, kPly, kWhole, kBuffer, kMaterials, kKinds };
constexpr const char* kNames[kKinds] = {"scene.gltf", "scene.glb", "scene.obj", "scene.ply",
                                        "scene.any",  "data.bin",  "lamp.mtl"};

void PutChunk(std::string_view type, std::string content, char padding, std::string& glb) {
  content.resize((content.size() + 3) / 4 * 4, padding);
  PutWord(static_cast<uint32_t>(content.size()), glb);
  glb.append(type).append(content);
}

std::string GlbOf(const std::string& json, const std::string& bytes) {
  std::string chunks;
  PutChunk("JSON", json, ' ', chunks);
  if (!bytes.empty()) PutChunk(std::string_view("BIN\0", 4), bytes, '\0', chunks);
  std::string glb = "glTF";
  for (const size_t word : {size_t{2}, 12 + chunks.size()}) {
    PutWord(static_cast<uint32_t>(word), glb);
  }
  return glb + chunks;
}

template <typename T>
void CheckIds(const std::vector<T>& objects) {
  std::set<std::string> ids;
  for (const T& object : objects) {
    Require(CheckId(object.id, "id").ok(), "ids are ids");
    Require(ids.insert(object.id).second, "each id is there once");
  }
}

void CheckCamera(const ImportedCamera& camera) {
  constexpr float kTolerance = 1e-3f;
  Require(IsFinite(camera.position), "a camera is somewhere");
  Require(std::abs(glm::length(camera.forward) - 1) < kTolerance &&
              std::abs(glm::length(camera.up) - 1) < kTolerance &&
              std::abs(glm::dot(camera.forward, camera.up)) < kTolerance,
          "a camera looks somewhere");
  Require(camera.fov_y > 0 && camera.fov_y < 3.15f, "a camera has an opening");
}

class SceneFiles final : public Target {
 public:
  std::span<const StepKind> kinds() const override { return kinds_; }
  void Run(const Script& script) override;
  std::vector<Seed> Seeds() override;

 private:
  std::string PathOf(uint8_t kind) const { return folder_ / kNames[kind]; }
  void Import(const std::string& path);
  void CheckScene(const ImportedScene& imported, const ImportedScene& again) const;

  const StepKind kinds_[kKinds] = {{"gltf"},  {"glb"},    {"obj"},      {"ply"},
                                   {"whole"}, {"buffer"}, {"materials"}};
  const SceneLimits limits_ = SmallLimits();
  const testing::TemporaryFolder folder_;
};

void SceneFiles::Run(const Script& script) {
  std::error_code error;
  for (uint8_t kind = 0; kind < kKinds; ++kind) std::filesystem::remove(PathOf(kind), error);
  std::string buffer;
  for (const Step& step : script) {
    const auto kind = static_cast<uint8_t>(step.kind % kKinds);
    if (kind != kBuffer && kind != kMaterials) continue;
    WriteAnew(PathOf(kind), step.payload);
    if (kind == kBuffer) buffer = step.payload;
  }
  for (const Step& step : script) {
    const auto kind = static_cast<uint8_t>(step.kind % kKinds);
    if (kind == kBuffer || kind == kMaterials) continue;
    WriteAnew(PathOf(kind), kind == kGlb ? GlbOf(step.payload, buffer) : step.payload);
    Import(PathOf(kind));
  }
}

void SceneFiles::Import(const std::string& path) {
  const auto imported = ImportScene(path, limits_);
  Count(imported.ok());
  const auto again = ImportScene(path, limits_);
  Require(imported.status() == again.status(), "a file is the same each time");
  if (!imported.ok()) return RequireNamedRefusal(imported.status());
  CheckIds(imported->instances);
  CheckIds(imported->lights);
  CheckIds(imported->cameras);
  for (const ImportedCamera& camera : imported->cameras) CheckCamera(camera);
  CheckScene(*imported, *again);
}

void SceneFiles::CheckScene(const ImportedScene& imported, const ImportedScene& again) const {
  Require(imported.warnings == again.warnings, "warnings are the same each time");
  const auto empty = Scene::Empty("file");
  const auto scene = empty->Apply(ToSceneDelta(imported), limits_);
  const auto scene_again = empty->Apply(ToSceneDelta(again), limits_);
  Require(scene.status() == scene_again.status(), "a scene is the same each time");
  if (!scene.ok()) return RequireNamedRefusal(scene.status());
  Require((*scene)->content_hash() == (*scene_again)->content_hash(),
          "a scene is the same each time");
  RequireRules(**scene, limits_);
}

constexpr char kTriangleJson[] = R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1]}],
"nodes":[{"name":"a table","mesh":0,"translation":[0,1,0]},{"name":"eye","camera":0}],
"cameras":[{"type":"perspective","perspective":{"yfov":0.8,"znear":0.1}}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0}]}],
"materials":[{"emissiveFactor":[0,0,0],"pbrMetallicRoughness":{"baseColorFactor":[1,0.5,0,1]}}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3",
"min":[0,0,0],"max":[1,1,0]}],
"bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36)";

std::string TriangleJson(const std::string& uri) { return absl::StrCat(kTriangleJson, uri, "}]}"); }

std::string TriangleBytes() {
  std::string bytes;
  for (const float number : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f}) {
    bytes.append(reinterpret_cast<const char*>(&number), sizeof(number));
  }
  return bytes;
}

std::vector<Seed> SceneFiles::Seeds() {
  const std::string obj =
      "mtllib lamp.mtl\no floor\nv -1 0 -1\nv -1 0 1\nv 1 0 1\nv 1 0 -1\nvt 0 0\nvn 0 1 0\n"
      "usemtl grey\nf 1/1/1 2/1/1 3/1/1 4/1/1\no lamp\nv 0 1 0\nv 1 1 0\nv 1 1 1\nv 0 1 1\n"
      "usemtl glow\nf -4 -3 -2 -1\n";
  const std::string materials = "newmtl grey\nKd 0.5 0.5 0.5\nnewmtl glow\nKd 1 1 1\nKe 10 9 8\n";
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
      "property float z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n"
      "0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n";
  return {
      {"gltf", {{kBuffer, TriangleBytes()}, {kGltf, TriangleJson(R"(,"uri":"data.bin")")}}},
      {"glb", {{kBuffer, TriangleBytes()}, {kGlb, TriangleJson("")}}},
      {"obj", {{kMaterials, materials}, {kObj, obj}}},
      {"ply", {{kPly, ply}}},
      {"whole", {{kWhole, GlbOf(TriangleJson(""), TriangleBytes())}}},
  };
}

}  // namespace

Target& TheTarget() {
  static SceneFiles target;
  return target;
}

}  // namespace penumbra::fuzzing
