#include "client/cli/volume_files.h"

#include <assimp/scene.h>

#include <algorithm>
#include <array>
#include <assimp/Exporter.hpp>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client/cli/output_files.h"
#include "client/cli/stacked_faces.h"
#include "client/display/image_io.h"
#include "render/artifact/light_extent.h"
#include "render/math/aabb.h"

namespace penumbra {
namespace {

// Where boundaries end that have no end: so many times as far as anything else.
constexpr float kFar = 4.0f;

StackedImage DepthsOf(const ShadowVolumeMesh& mesh) {
  std::vector<StackedFace> faces;
  for (const auto& volume : mesh.volumes) {
    for (const VolumeFace& face : volume->faces) faces.push_back({face.map.view, face.map.depths});
  }
  return Stack(faces, kNoDepth);
}

// Images of more are not made.
constexpr size_t kMaxStackedSamples = size_t{1} << 26;

// Triangles of places in the world, from homogeneous ones.
class FinitePlaces {
 public:
  explicit FinitePlaces(const ShadowVolumeMesh& mesh) {
    const DVec4 middle = PlaceOfMiddle(mesh.light);
    if (middle.w == 0) {
      from_light_ = -Vec3(DVec3(middle));
    } else {
      light_ = Vec3(DVec3(middle));
    }
    Aabb bounds;
    for (const auto& volume : mesh.volumes) {
      for (const Vec4& v : volume->vertices) {
        if (v.w > 0) bounds.Add(Vec3(v) / v.w);
      }
    }
    if (!bounds.empty()) far_ = kFar * std::max(1.0f, glm::length(bounds.extent()));
    if (!bounds.empty() && !IsParallel()) {
      far_ = std::max(far_, kFar * glm::distance(bounds.center(), light_));
    }
  }

  // Appends the triangle's corners, three a triangle. Where light is parallel all that is
  // infinitely far is one point, and a triangle that reaches there a strip.
  void Add(const std::array<Vec4, 3>& triangle, std::vector<Vec3>& corners) const {
    if (!IsParallel()) {
      for (const Vec4& v : triangle) corners.push_back(Place(v));
      return;
    }
    const auto is_far = [](const Vec4& v) { return v.w == 0; };
    const auto count = std::ranges::count_if(triangle, is_far);
    if (count == 0) {
      for (const Vec4& v : triangle) corners.push_back(Place(v));
    }
    if (count != 1) return;
    const auto end = std::ranges::find_if(triangle, is_far) - triangle.begin();
    const Vec3 a = Place(triangle[(end + 1) % 3]), b = Place(triangle[(end + 2) % 3]);
    const Vec3 way = far_ * from_light_;
    corners.insert(corners.end(), {a, b, b + way, a, b + way, a + way});
  }

 private:
  bool IsParallel() const { return from_light_ != Vec3(0); }
  Vec3 Place(const Vec4& v) const {
    return v.w > 0 ? Vec3(v) / v.w : light_ + far_ * glm::normalize(Vec3(v));
  }

  Vec3 light_{0};
  Vec3 from_light_{0};  // of length 1 where light is parallel
  float far_ = 1.0f;
};

std::vector<Vec3> CornersOf(const ShadowVolume& volume, const FinitePlaces& places) {
  std::vector<Vec3> corners;
  for (size_t i = 0; i + 2 < volume.indices.size(); i += 3) {
    std::array<Vec4, 3> triangle;
    for (size_t k = 0; k < 3; ++k) triangle[k] = volume.vertices[volume.indices[i + k]];
    // As often as it weighs; a weight below 0 is that of the other side.
    const int weight = volume.weights.empty() ? 1 : volume.weights[i / 3];
    if (weight < 0) std::swap(triangle[1], triangle[2]);
    for (int k = 0; k < std::abs(weight); ++k) places.Add(triangle, corners);
  }
  return corners;
}

// The exporter's scene owns what is in it, and deletes it.
aiMesh* MeshFrom(const std::vector<Vec3>& corners, const std::string& name) {
  auto* const mesh = new aiMesh();
  mesh->mName = name;
  mesh->mPrimitiveTypes = aiPrimitiveType_TRIANGLE;
  mesh->mNumVertices = static_cast<unsigned>(corners.size());
  mesh->mVertices = new aiVector3D[corners.size()];
  mesh->mNumFaces = static_cast<unsigned>(corners.size() / 3);
  mesh->mFaces = new aiFace[corners.size() / 3];
  for (unsigned i = 0; i < mesh->mNumVertices; ++i) {
    mesh->mVertices[i] = {corners[i].x, corners[i].y, corners[i].z};
  }
  for (unsigned t = 0; t < mesh->mNumFaces; ++t) {
    mesh->mFaces[t].mNumIndices = 3;
    mesh->mFaces[t].mIndices = new unsigned[3]{3 * t, 3 * t + 1, 3 * t + 2};
  }
  return mesh;
}

std::unique_ptr<aiScene> SceneFrom(const ShadowVolumeMesh& mesh) {
  const FinitePlaces places(mesh);
  std::vector<aiMesh*> meshes;
  for (const auto& volume : mesh.volumes) {
    const std::vector<Vec3> corners = CornersOf(*volume, places);
    if (corners.empty()) continue;
    meshes.push_back(
        MeshFrom(corners, volume->instance_id.empty() ? "shadow" : volume->instance_id));
  }
  auto scene = std::make_unique<aiScene>();
  scene->mNumMaterials = 1;
  scene->mMaterials = new aiMaterial* [1] { new aiMaterial() };
  scene->mNumMeshes = static_cast<unsigned>(meshes.size());
  scene->mMeshes = new aiMesh*[meshes.size()];
  std::ranges::copy(meshes, scene->mMeshes);
  scene->mRootNode = new aiNode("shadows");
  scene->mRootNode->mNumChildren = scene->mNumMeshes;
  scene->mRootNode->mChildren = new aiNode*[meshes.size()];
  for (unsigned i = 0; i < scene->mNumMeshes; ++i) {
    auto* const node = new aiNode(meshes[i]->mName.C_Str());
    node->mParent = scene->mRootNode;
    node->mNumMeshes = 1;
    node->mMeshes = new unsigned[1]{i};
    scene->mRootNode->mChildren[i] = node;
  }
  return scene;
}

}  // namespace

bool HasImages(const ShadowVolumeMesh& mesh) {
  size_t width = 0, height = 0;
  for (const auto& volume : mesh.volumes) {
    for (const VolumeFace& face : volume->faces) {
      width = std::max<size_t>(width, face.map.view.width);
      height += face.map.view.height;
    }
  }
  return width > 0 && height <= kMaxStackedSamples / width;
}

RadianceTexture PictureOf(const ShadowVolumeMesh& mesh) {
  if (!HasImages(mesh)) return {};
  const StackedImage depths = DepthsOf(mesh);
  float nearest = kNoDepth, farthest = -kNoDepth;
  for (const float depth : depths.numbers) {
    if (!std::isfinite(depth)) continue;
    nearest = std::min(nearest, depth), farthest = std::max(farthest, depth);
  }
  // What is farthest is not black, so that it is told from nothing.
  const float range = std::max(farthest - nearest, 1e-6f);
  RadianceTexture picture{.width = depths.width, .height = depths.height, .texels = {}};
  for (const float depth : depths.numbers) {
    picture.texels.emplace_back(std::isfinite(depth) ? 1.0f - 0.8f * (depth - nearest) / range
                                                     : 0.0f);
  }
  return picture;
}

absl::Status WriteNumbers(const std::filesystem::path& path, const ShadowVolumeMesh& mesh,
                          const RadianceTexture& picture) {
  const StackedImage depths = DepthsOf(mesh);
  const NamedPlane channels[] = {{"depth", depths.numbers}};
  return WriteExr(path, static_cast<int>(picture.width), static_cast<int>(picture.height),
                  channels);
}

absl::Status WriteBoundary(const std::filesystem::path& path, const ShadowVolumeMesh& mesh) {
  const std::string extension = path.extension().string();
  const char* const format = extension == ".glb"   ? "glb2"
                             : extension == ".ply" ? "plyb"
                                                   : "objnomtl";
  const auto scene = SceneFrom(mesh);
  Assimp::Exporter exporter;
  // By way of memory: assimp does not tell of a full disk.
  const aiExportDataBlob* const blob = exporter.ExportToBlob(scene.get(), format);
  if (blob == nullptr) {
    return absl::InternalError(absl::StrCat(path.string(), ": ", exporter.GetErrorString()));
  }
  return WriteText(path, {static_cast<const char*>(blob->data), blob->size});
}

}  // namespace penumbra
