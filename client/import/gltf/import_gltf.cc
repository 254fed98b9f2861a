#include "client/import/gltf/import_gltf.h"

#include <cmath>
#include <map>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/import/emitter.h"
#include "client/import/gltf/document.h"
#include "client/import/gltf/geometry.h"
#include "client/import/gltf/lights.h"
#include "client/import/gltf/materials.h"
#include "client/import/gltf/placements.h"
#include "client/import/gltf/skin.h"
#include "client/import/gltf/transforms.h"
#include "client/import/id_table.h"
#include "client/import/source_file.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace gltf {
namespace {

class SceneReader {
 public:
  explicit SceneReader(Document& document)
      : document_(document), materials_(document, warnings_), geometry_(document, warnings_) {}

  absl::StatusOr<ImportedScene> Read();

 private:
  absl::Status ReadNode(const PlacedNode& placed);
  absl::Status ReadMesh(const PlacedNode& placed);
  absl::StatusOr<std::shared_ptr<const Mesh>> Skinned(const tinygltf::Node& node, int primitive,
                                                      const Material& material);
  absl::Status AddInstance(Instance instance, const std::string& name, const Material& material);
  void AddLight(const std::string& name, LightShape shape);
  void ReadCamera(const PlacedNode& placed);
  std::string NameOf(int node) const;

  Document& document_;
  Warnings warnings_;
  Materials materials_;
  Geometry geometry_;
  std::map<int, DMat4> world_from_node_;
  IdTable instance_ids_, light_ids_, camera_ids_;
  ImportedScene scene_;
};

std::string SceneReader::NameOf(int node) const {
  const tinygltf::Model& model = document_.model();
  const tinygltf::Node& source = model.nodes[node];
  if (!source.name.empty()) return source.name;
  if (source.mesh >= 0 && !model.meshes[source.mesh].name.empty()) {
    return model.meshes[source.mesh].name;
  }
  return absl::StrCat("node", node);
}

absl::StatusOr<ImportedScene> SceneReader::Read() {
  absl::StatusOr<std::vector<PlacedNode>> nodes = PlaceNodes(document_.model(), warnings_);
  if (!nodes.ok()) return nodes.status();
  for (const PlacedNode& placed : *nodes) world_from_node_[placed.node] = placed.world_from_node;
  for (const PlacedNode& placed : *nodes) {
    absl::Status status = ReadNode(placed);
    if (!status.ok()) return status;
  }
  scene_.warnings = warnings_.lines();
  return std::move(scene_);
}

absl::Status SceneReader::ReadNode(const PlacedNode& placed) {
  const tinygltf::Model& model = document_.model();
  if (model.nodes[placed.node].mesh >= 0) {
    absl::Status status = ReadMesh(placed);
    if (!status.ok()) return status;
  }
  for (NodeLight& light : LightsOf(model, placed, warnings_)) {
    if (scene_.lights.size() >= document_.limits().max_lights) {
      return FieldError(absl::StatusCode::kResourceExhausted, "QUOTA_LIGHTS",
                        absl::StrCat("nodes[", placed.node, "]"),
                        absl::StrCat("found more lights, need <= ", document_.limits().max_lights));
    }
    const std::string& node_name = model.nodes[placed.node].name;
    AddLight(node_name.empty() && !light.name.empty() ? light.name : NameOf(placed.node),
             std::move(light.shape));
  }
  if (model.nodes[placed.node].camera >= 0) ReadCamera(placed);
  return absl::OkStatus();
}

absl::StatusOr<std::shared_ptr<const Mesh>> SceneReader::Skinned(const tinygltf::Node& node,
                                                                 int primitive,
                                                                 const Material& material) {
  const std::string path = absl::StrCat("meshes[", node.mesh, "].primitives[", primitive, "]");
  const tinygltf::Mesh& mesh = document_.model().meshes[node.mesh];
  auto geometry = geometry_.Read(node.mesh, primitive, material.mask_uv,
                                 node.weights.empty() ? mesh.weights : node.weights);
  if (!geometry.ok()) return geometry.status();
  if (!*geometry) return nullptr;
  auto weights = geometry_.ReadSkinWeights(node.mesh, primitive);
  if (!weights.ok()) return weights.status();
  auto joints = JointMatrices(document_, node.skin, world_from_node_);
  if (!joints.ok()) return joints.status();
  if (weights->pairs > 0) {
    absl::Status status = Bend(*weights, *joints, path, **geometry);
    if (!status.ok()) return status;
  }
  return geometry_.Finish(**std::move(geometry), path);
}

absl::Status SceneReader::ReadMesh(const PlacedNode& placed) {
  const tinygltf::Node& node = document_.model().nodes[placed.node];
  const tinygltf::Mesh& mesh = document_.model().meshes[node.mesh];
  absl::StatusOr<std::vector<Affine>> placements = PlacementsOf(document_, placed);
  if (!placements.ok()) return placements.status();
  // A skin places its vertices in the world by itself.
  if (node.skin >= 0) *placements = {IdentityAffine()};
  for (size_t p = 0; p < mesh.primitives.size(); ++p) {
    const Material& material = materials_.Get(mesh.primitives[p].material);
    if (material.absent) {
      warnings_.Add(absl::StrCat("materials[", mesh.primitives[p].material,
                                 "]: cut away everywhere, its surfaces are left out"));
      continue;
    }
    auto shape = node.skin >= 0 ? Skinned(node, static_cast<int>(p), material)
                                : geometry_.Get(node.mesh, static_cast<int>(p), material.mask_uv,
                                                node.weights.empty() ? mesh.weights : node.weights);
    if (!shape.ok()) return shape.status();
    if (*shape == nullptr) continue;
    const std::string name = mesh.primitives.size() == 1
                                 ? NameOf(placed.node)
                                 : absl::StrCat(NameOf(placed.node), ".", p);
    for (const Affine& placement : *placements) {
      absl::Status status =
          AddInstance({.mesh = *shape, .world_from_mesh = placement}, name, material);
      if (!status.ok()) return WithFieldPrefix(status, absl::StrCat("nodes[", placed.node, "]"));
    }
  }
  return absl::OkStatus();
}

absl::Status SceneReader::AddInstance(Instance instance, const std::string& name,
                                      const Material& material) {
  if (scene_.instances.size() >= document_.limits().max_instances) {
    return FieldError(
        absl::StatusCode::kResourceExhausted, "QUOTA_INSTANCES", "",
        absl::StrCat("found more instances, need <= ", document_.limits().max_instances));
  }
  if (!IsFinite(instance.world_from_mesh)) {
    return Malformed("NON_FINITE", "", "found a transform that overflows, need finite numbers");
  }
  instance.id = instance_ids_.Add(name);
  instance.casts = material.casts;
  instance.color = material.color;
  if (material.mask && !instance.mesh->uvs().empty()) {
    instance.alpha_mask = material.mask;
    instance.alpha_cutoff = material.cutoff;
  }
  if (material.emission != Vec3(0.0f)) {
    auto shape = EmitterShape(instance, material.emission, material.two_sided);
    if (shape && scene_.lights.size() < document_.limits().max_lights) {
      // The light must not stand in its own way, and outshines what falls on it.
      instance.casts = false;
      instance.receives = false;
      AddLight(instance.id, *shape);
    } else {
      warnings_.Add(absl::StrCat(instance.id,
                                 ": glows, but is no flat parallelogram and no sphere: no light"));
    }
  }
  scene_.instances.push_back(std::move(instance));
  return absl::OkStatus();
}

void SceneReader::AddLight(const std::string& name, LightShape shape) {
  scene_.lights.push_back({.id = light_ids_.Add(name), .shape = std::move(shape)});
}

void SceneReader::ReadCamera(const PlacedNode& placed) {
  const int index = document_.model().nodes[placed.node].camera;
  const tinygltf::Camera& camera = document_.model().cameras[index];
  const DVec3 back(placed.world_from_node[2]), y(placed.world_from_node[1]);
  const DVec3 up = y - glm::dot(y, back) / glm::dot(back, back) * back;
  // What is left of an axis that runs along the other is rounding, in any direction.
  constexpr double kLeastAngle = 1e-9;
  const bool has_frame = std::isnormal(glm::dot(back, back)) && std::isnormal(glm::dot(up, up)) &&
                         glm::length(up) > kLeastAngle * glm::length(y);
  const double fov = camera.perspective.yfov;
  if (camera.type != "perspective" || !(fov > 0.0 && fov < 3.14) || !has_frame) {
    warnings_.Add(absl::StrCat("cameras[", index, "]: not a usable perspective, ignored"));
    return;
  }
  scene_.cameras.push_back({.id = camera_ids_.Add(NameOf(placed.node)),
                            .position = Vec3(DVec3(placed.world_from_node[3])),
                            .forward = Vec3(-glm::normalize(back)),
                            .up = Vec3(glm::normalize(up)),
                            .fov_y = static_cast<float>(fov)});
}

}  // namespace
}  // namespace gltf

absl::StatusOr<ImportedScene> ImportGltf(const std::filesystem::path& path,
                                         const SceneLimits& limits) {
  absl::StatusOr<std::unique_ptr<gltf::Document>> document = gltf::Document::Open(path, limits);
  if (!document.ok()) return document.status();
  return gltf::SceneReader(**document).Read();
}

}  // namespace penumbra
