#include "render/technique/shadow_volume/object_volumes.h"

#include <cmath>
#include <utility>

#include "render/scene/hashed_bytes.h"
#include "render/scene/scene_hash.h"
#include "render/technique/shadow_volume/shadow_volume_builder.h"
#include "render/technique/shadow_volume/silhouette_volume.h"
#include "render/technique/shadow_volume/volume_hash.h"

namespace penumbra {
namespace {

// Down to a power of √2, so that a caster that moves a little leaves it as it is.
double SteadyPitch(double pitch) {
  return pitch > 0 ? std::exp2(0.5 * std::floor(2 * std::log2(pitch))) : 0.0;
}

bool IsObjectPrecise(const Instance& instance, ObjectPrecision precision) {
  return precision == ObjectPrecision::kWhereItIsLess && !instance.alpha_mask &&
         instance.mesh->triangle_count() <= kMostObjectTriangles;
}

ContentHash HashOfCaster(const Instance& instance, ObjectPrecision precision, double pitch) {
  HashedBytes bytes;
  bytes.Put(HashOf(instance));
  bytes.Put(static_cast<uint32_t>(precision));
  bytes.Put(static_cast<float>(pitch));
  return bytes.Hash();
}

}  // namespace

absl::StatusOr<ObjectVolumes::Kept> ObjectVolumes::Make(
    const std::shared_ptr<const Instance>& instance, const AreaLight& light, double pitch,
    const std::stop_token& stop) {
  Kept kept;
  if (IsObjectPrecise(*instance, precision_)) {
    kept.volume = std::make_shared<ShadowVolume>(SilhouetteVolume(*instance, light));
    return kept;
  }
  const Aabb box = WorldBounds(*instance);
  const auto views = VolumeViews(light, std::span(&box, 1), pitch);
  if (views.empty()) return kept;
  SceneDelta delta;
  delta.upsert_instances.push_back(*instance);
  const auto alone = Scene::Empty("caster")->Apply(delta);
  if (!alone.ok()) return alone.status();
  auto source = source_of_(**alone);
  if (!source.ok()) return source.status();
  auto faces = DrawFaces(views, **source, stop);
  if (!faces.ok()) return faces.status();
  ReconstructedVolume built = ReconstructVolume(*std::move(faces), options_);
  kept.edge_fraction = built.edge_fraction;
  kept.volume = std::make_shared<ShadowVolume>(std::move(built.volume));
  return kept;
}

absl::StatusOr<ShadowVolumeMesh> ObjectVolumes::Update(const Scene& scene, const AreaLight& light,
                                                       const std::stop_token& stop) {
  if (const auto status = CheckShadowVolumeOptions(options_); !status.ok()) return status;
  made_ = 0;
  Aabb bounds;
  for (const Aabb& box : scene.casters().bounds()) bounds.Add(box);
  const double pitch = SteadyPitch(PitchFor(light, bounds, options_.resolution));
  ShadowVolumeMesh mesh{.light = light, .bias_px = options_.bias_px, .volumes = {}};
  std::map<std::string, Kept> next;
  double edge_fraction = 0;
  for (const auto& [id, instance] : scene.instances()) {
    if (!instance->casts || instance->mesh->triangle_count() == 0) continue;
    const ContentHash content =
        HashOfVolume(HashOfCaster(*instance, precision_, pitch), light, options_);
    Kept& kept = kept_[id];
    if (kept.content != content) {
      auto made = Make(instance, light, pitch, stop);
      if (!made.ok()) return made.status();
      kept = *std::move(made);
      kept.content = content;
      ++made_;
    }
    edge_fraction += kept.edge_fraction;
    if (kept.volume) {
      mesh.volumes.push_back(*kept.volume);
      mesh.volumes.back().instance_id = id;
      mesh.volumes.back().content = content;
    }
    next[id] = kept;
  }
  kept_ = std::move(next);
  if (!kept_.empty()) {
    mesh.edge_fraction = static_cast<float>(edge_fraction / static_cast<double>(kept_.size()));
  }
  return mesh;
}

}  // namespace penumbra
