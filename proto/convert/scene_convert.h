// Scenes and their changes, both ways.
//
//   auto delta = FromProto(request.delta(), blobs);
//   if (!delta.ok()) return delta.status();
#pragma once

#include <cstddef>
#include <memory>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "penumbra/v1/scene.pb.h"
#include "penumbra/v1/server_info.pb.h"
#include "render/engine/engine.h"
#include "render/scene/scene.h"

namespace penumbra {

// Where the meshes and masks are that instances name by hash.
class BlobSource {
 public:
  virtual ~BlobSource() = default;
  // Null when there is none of that name.
  virtual std::shared_ptr<const Mesh> FindMesh(const ContentHash& hash) const = 0;
  virtual std::shared_ptr<const AlphaMask> FindMask(const ContentHash& hash) const = 0;
};

v1::Instance ToProto(const Instance& instance);
v1::Receiver ToProto(const Receiver& receiver);
v1::ReceiveOnPlanarSurfaces ToProto(const PlanarSurfaceRequest& request);
v1::SceneDelta ToProto(const SceneDelta& delta);
v1::SceneInfo ToProto(const SceneInfo& info);
SceneInfo InfoOf(const Scene& scene);

// The same as ToProto(delta), in pieces of at most `max_bytes` each (one object at least), to be
// put together again: a piece alone may not fit the scene. base_revision is left out, and so is
// receive_on_planar_surfaces, which no difference between two scenes has.
std::vector<v1::SceneDelta> ToProtoPieces(const SceneDelta& delta, size_t max_bytes);

// Errors  all name the field as Scene::Apply does, "upsert_instances[3].mesh_hash":
//         kInvalidArgument     MISSING_FIELD, LENGTH
//         kFailedPrecondition  MISSING_BLOB: a mesh or mask that is not in `blobs`
absl::StatusOr<Instance> FromProto(const v1::Instance& instance, const BlobSource& blobs,
                                   std::string_view field_path);
absl::StatusOr<Receiver> FromProto(const v1::Receiver& receiver, std::string_view field_path);
PlanarSurfaceRequest FromProto(const v1::ReceiveOnPlanarSurfaces& request);
absl::StatusOr<SceneDelta> FromProto(const v1::SceneDelta& delta, const BlobSource& blobs);
// Errors  kInvalidArgument LENGTH
absl::StatusOr<SceneInfo> FromProto(const v1::SceneInfo& info);

// The limits of scenes alone; a limit that was not told keeps its default.
SceneLimits SceneLimitsFromProto(const v1::Limits& limits);
void WriteSceneLimits(const SceneLimits& limits, v1::Limits& proto);

}  // namespace penumbra
