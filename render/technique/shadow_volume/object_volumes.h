// A volume for each caster, of which those are made anew that changed.
//
//   ObjectVolumes volumes(options, ObjectPrecision::kNever);   // kept from revision to revision
//   auto mesh = volumes.Update(*scene, light, source_of, stop);
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <stop_token>
#include <string>

#include "absl/status/statusor.h"
#include "render/artifact/shadow_volume_mesh.h"
#include "render/light_view/depth_source.h"
#include "render/scene/scene.h"
#include "render/technique/shadow_volume/shadow_volume_options.h"

namespace penumbra {

// Which casters have their volume made from their own triangles, and not from a map.
enum class ObjectPrecision : uint8_t {
  kNever,
  kWhereItIsLess,  // those with fewer triangles than kMostObjectTriangles, and without a mask
};
inline constexpr size_t kMostObjectTriangles = 5000;

// What lies in any of the volumes is in shadow. Each is reconstructed from a map of its caster
// alone, with samples as far apart as one map of all would have, to the next power of √2 below: as
// long as that stays the same a volume depends on its caster and the light alone, and is kept, as
// are the names by which others know that they have it.
//
// Source  McCool 2000, §8.2
class ObjectVolumes {
 public:
  // Makes the depth source of a scene, which outlives it.
  using SourceOf = std::function<absl::StatusOr<std::unique_ptr<DepthSource>>(const Scene& scene)>;

  ObjectVolumes(const ShadowVolumeOptions& options, ObjectPrecision precision)
      : options_(options), precision_(precision) {}

  // Volumes of all casters that the light sees, in the order of instances; those made from edges
  // wherever the light shines.
  //
  // Errors  those of CheckShadowVolumeOptions, CheckVolumeTexels, CheckVolumeSize,
  //         `source_of` and DepthSource::Draw, after which what was made is kept
  absl::StatusOr<ShadowVolumeMesh> Update(const Scene& scene, const AreaLight& light,
                                          const SourceOf& source_of, const std::stop_token& stop);

  // Volumes that the last Update made anew.
  size_t made() const { return made_; }

 private:
  struct Kept {
    ContentHash content{};
    // Null: the light sees nothing of it. Left as it is once a mesh has it.
    std::shared_ptr<ShadowVolume> volume{};
    double edge_fraction = 0;
    size_t places = 0;  // that it is a fraction of
  };

  struct Making;

  void Forget(const std::map<std::string, ContentHash>& wanted);
  ShadowVolumeMesh MeshOfKept(const AreaLight& light) const;

  absl::StatusOr<Kept> Make(const Instance& instance, const ContentHash& content,
                            const Making& making) const;
  absl::StatusOr<Kept> MakeFromMap(const Instance& instance, const Making& making) const;

  const ShadowVolumeOptions options_;
  const ObjectPrecision precision_;
  std::map<std::string, Kept> kept_;  // by instance
  size_t made_ = 0;
};

}  // namespace penumbra
