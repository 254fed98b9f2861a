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
  size_t triangles = 0, vertices = 0;
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
  auto built = ReconstructVolume(*std::move(faces), options_, making.stop);
  if (!built.ok()) return built.status();
  return Kept{.volume = std::make_shared<ShadowVolume>(std::move(built->volume)),
              .edge_fraction = built->edge_fraction,
              .places = built->places};
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

// What the light, or an edit, left nothing of.
void ObjectVolumes::Forget(const std::map<std::string, ContentHash>& wanted) {
  std::erase_if(kept_, [&](const auto& entry) {
    const auto content = wanted.find(entry.first);
    return content == wanted.end() || content->second != entry.second.content;
  });
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
  std::map<std::string, ContentHash> wanted;
  for (const auto& [id, instance] : scene.instances()) {
    if (!instance->casts || instance->mesh->triangle_count() == 0) continue;
    wanted[id] = HashOfVolume(HashOfCaster(*instance, precision_, making.pitch), light, options_);
  }
  Forget(wanted);
  for (const auto& [id, content] : wanted) {
    if (stop.stop_requested()) return absl::CancelledError("stopped");
    if (!kept_.contains(id)) {
      auto made = Make(*scene.FindInstance(id), content, making);
      if (!made.ok()) return made.status();
      kept_[id] = *std::move(made);
      ++made_;
    }
    if (const auto& volume = kept_[id].volume) {
      making.texels += volume->sample_count();
      making.triangles += volume->weighed_triangle_count() + volume->caster_indices.size() / 3;
      making.vertices += volume->vertices.size();
    }
    absl::Status status = CheckVolumeTexels(making.texels, {});
    status.Update(CheckVolumeSize(making.triangles, making.vertices));
    if (!status.ok()) return status;
  }
  return MeshOfKept(light);
}

ShadowVolumeMesh ObjectVolumes::MeshOfKept(const AreaLight& light) const {
  ShadowVolumeMesh mesh{.light = light, .bias_px = options_.bias_px, .volumes = {}};
  double edges = 0, places = 0;
  for (const auto& [id, kept] : kept_) {
    if (kept.volume == nullptr) continue;
    mesh.volumes.push_back(kept.volume);
    const auto count = static_cast<double>(kept.places);
    edges += kept.edge_fraction * count, places += count;
  }
  if (places > 0) mesh.edge_fraction = static_cast<float>(edges / places);
  return mesh;
}

}  // namespace penumbra
