// Shadow volumes, part by part, that a server sends to a client.

#include <memory>
#include <utility>

#include "tests/fuzz/targets/artifact_updates.h"
#include "tests/support/random_volume_mesh.h"

namespace penumbra::fuzzing {
namespace {

using testing::RandomVolume;

ShadowVolume Small(uint32_t seed, VolumeKind kind) {
  ShadowVolume volume = RandomVolume(seed, 12, kind);
  if (kind == VolumeKind::kObject) return volume;
  std::mt19937 random(seed);
  volume.faces = {testing::RandomVolumeFace(random, kind == VolumeKind::kVectorized ? 66 : 6, 3)};
  return volume;
}

Artifact With(std::vector<ShadowVolume> volumes) {
  ShadowVolumeMesh mesh{.light = {.id = "l", .shape = PointLight{.position = Vec3(1, 2, 3)}},
                        .bias_px = 0.5f,
                        .volumes = {},
                        .edge_fraction = 0.125f};
  for (ShadowVolume& volume : volumes) {
    mesh.volumes.push_back(std::make_shared<ShadowVolume>(std::move(volume)));
  }
  Artifact artifact{.header = {.technique = "shadow_volume"}, .payload = std::move(mesh)};
  artifact.header.light_samples = {{}};
  return artifact;
}

class VolumeUpdates final : public ArtifactUpdates {
 public:
  std::vector<Seed> Seeds() override {
    const ShadowVolume seen = Small(1, VolumeKind::kReconstructed);
    const ShadowVolume lines = Small(2, VolumeKind::kVectorized);
    const ShadowVolume thing = Small(3, VolumeKind::kObject);
    std::vector<Seed> seeds = SeedsOf("seen", With({seen}), With({lines}));
    for (auto more :
         {SeedsOf("object", With({thing}), With({thing, Small(4, VolumeKind::kObject)})),
          SeedsOf("several", With({seen, lines, thing}), With({thing, seen}))}) {
      seeds.insert(seeds.end(), more.begin(), more.end());
    }
    return seeds;
  }
};

}  // namespace

Target& TheTarget() {
  static VolumeUpdates target;
  return target;
}

}  // namespace penumbra::fuzzing
