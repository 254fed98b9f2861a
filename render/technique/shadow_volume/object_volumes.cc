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

// What making a volume takes besides its caster.
struct ObjectVolumes::Making {
  const AreaLight& light;
  double pitch;
  uint64_t texels = 0;  // of the maps of all volumes so far
  const SourceOf& source_of;
  const std::stop_token& stop;
};

absl::StatusOr<ObjectVolumes::Kept> ObjectVolumes::MakeFromMap(const Instance& instance,
                                                               const Making& making) const {
  const Aabb box = WorldBounds(instance);
  const auto views = VolumeViews(making.light, std::span(&box, 1), making.pitch);
  if (views.empty()) return Kept{};
  if (auto status = CheckVolumeTexels(making.texels, views); !status.ok()) return status;
  SceneDelta delta;
  delta.upsert_instances.push_back(instance);
  const auto alone = Scene::Empty("caster")->Apply(delta);
  if (!alone.ok()) return alone.status();
  auto source = making.source_of(**alone);
  if (!source.ok()) return source.status();
  auto faces = DrawFaces(views, **source, making.stop);
  if (!faces.ok()) return faces.status();
  ReconstructedVolume built = ReconstructVolume(*std::move(faces), options_);
  return Kept{.volume = std::make_shared<ShadowVolume>(std::move(built.volume)),
              .edge_fraction = built.edge_fraction};
}

absl::StatusOr<ObjectVolumes::Kept> ObjectVolumes::Make(const Instance& instance,
                                                        const ContentHash& content,
                                                        const Making& making) const {
  absl::StatusOr<Kept> kept =
      IsObjectPrecise(instance, precision_)
          ? absl::StatusOr<Kept>(Kept{
                .volume = std::make_shared<ShadowVolume>(SilhouetteVolume(instance, making.light))})
          : MakeFromMap(instance, making);
  if (!kept.ok()) return kept;
  kept->content = content;
  if (kept->volume) kept->volume->instance_id = instance.id, kept->volume->content = content;
  return kept;
}

absl::StatusOr<ShadowVolumeMesh> ObjectVolumes::Update(const Scene& scene, const AreaLight& light,
                                                       const SourceOf& source_of,
                                                       const std::stop_token& stop) {
  if (const auto status = CheckShadowVolumeOptions(options_); !status.ok()) return status;
  made_ = 0;
  Aabb bounds;
  for (const Aabb& box : scene.casters().bounds()) bounds.Add(box);
  Making making{.light = light,
                .pitch = SteadyPitch(PitchFor(light, bounds, options_.resolution)),
                .source_of = source_of,
                .stop = stop};
  ShadowVolumeMesh mesh{.light = light, .bias_px = options_.bias_px, .volumes = {}};
  std::map<std::string, Kept> next;
  double edge_fraction = 0;
  for (const auto& [id, instance] : scene.instances()) {
    if (!instance->casts || instance->mesh->triangle_count() == 0) continue;
    if (stop.stop_requested()) return absl::CancelledError("stopped");
    const ContentHash content =
        HashOfVolume(HashOfCaster(*instance, precision_, making.pitch), light, options_);
    Kept& kept = kept_[id];
    if (kept.content != content) {
      auto made = Make(*instance, content, making);
      if (!made.ok()) return made.status();
      kept = *std::move(made);
      ++made_;
    }
    if (kept.volume) {
      mesh.volumes.push_back(kept.volume);
      making.texels += kept.volume->sample_count();
      edge_fraction += kept.edge_fraction * static_cast<double>(kept.volume->sample_count());
    }
    next[id] = kept;
  }
  kept_ = std::move(next);
  if (making.texels > 0) {
    mesh.edge_fraction = static_cast<float>(edge_fraction / static_cast<double>(making.texels));
  }
  return mesh;
}

}  // namespace penumbra
