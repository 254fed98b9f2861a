// Shadow-width maps that a server sends to a client.

#include <random>
#include <utility>

#include "tests/fuzz/targets/artifact_updates.h"
#include "tests/support/random_width_map.h"

namespace penumbra::fuzzing {
namespace {

Artifact With(ShadowWidthMap map) {
  Artifact artifact{.header = {.technique = "shadow_width"}, .payload = std::move(map)};
  artifact.header.light_samples = {{}};
  return artifact;
}

Artifact Map(uint32_t seed, uint32_t width, bool from_infinity, bool has_far) {
  std::mt19937 random(seed);
  ShadowWidthMap map{.light = {.id = "lamp", .shape = SphereLight{.radius = 0.5f}},
                     .faces = {},
                     .c_scale = 2.0f,
                     .c_bias = 0.25f};
  map.faces.push_back(RandomWidthFace(width, 3, from_infinity, has_far, random));
  return With(std::move(map));
}

class WidthUpdates final : public ArtifactUpdates {
 public:
  std::vector<Seed> Seeds() override {
    std::vector<Seed> seeds = SeedsOf("small", Map(1, 9, false, false), Map(2, 9, false, false));
    for (auto more : {SeedsOf("two-layers", Map(3, 9, true, true), Map(4, 9, true, false)),
                      SeedsOf("tiles", Map(5, 66, false, true), Map(6, 66, false, true))}) {
      seeds.insert(seeds.end(), more.begin(), more.end());
    }
    return seeds;
  }
};

}  // namespace

Target& TheTarget() {
  static WidthUpdates target;
  return target;
}

}  // namespace penumbra::fuzzing
