// Layered attenuation maps that a server sends to a client.

#include <random>
#include <utility>

#include "tests/fuzz/targets/artifact_updates.h"
#include "tests/support/random_ldi.h"

namespace penumbra::fuzzing {
namespace {

Artifact LayersOf(uint32_t samples, uint32_t width, uint32_t height, bool from_infinity) {
  std::mt19937 random(samples);
  AttenuationLdi ldi{.light = {.id = "lamp", .shape = DiskLight{.radius = 0.5f}},
                     .faces = {},
                     .sample_count = samples,
                     .tolerance = 1.25f};
  ldi.faces.push_back(RandomLdiFace(width, height, from_infinity, samples, random));
  Artifact artifact{.header = {.technique = "layered_attenuation"}, .payload = std::move(ldi)};
  artifact.header.light_samples = {{}};
  return artifact;
}

class LayerUpdates final : public ArtifactUpdates {
 public:
  std::vector<Seed> Seeds() override {
    std::vector<Seed> seeds =
        SeedsOf("small", LayersOf(64, 5, 3, false), LayersOf(16, 5, 3, false));
    for (auto more : {SeedsOf("parallel", LayersOf(300, 4, 3, true), LayersOf(64, 4, 3, true)),
                      SeedsOf("tiles", LayersOf(16, 34, 2, false), LayersOf(256, 34, 2, false))}) {
      seeds.insert(seeds.end(), more.begin(), more.end());
    }
    return seeds;
  }
};

}  // namespace

Target& TheTarget() {
  static LayerUpdates target;
  return target;
}

}  // namespace penumbra::fuzzing
