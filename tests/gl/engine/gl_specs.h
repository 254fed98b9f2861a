// Every technique that takes GL, and what its artifacts are to the last bit.
#pragma once

#include <string>
#include <vector>

#include "render/artifact/artifact.h"
#include "render/scene/scene.h"
#include "render/technique/artifact_spec.h"

namespace penumbra::testing {

struct GlSpec {
  std::string name;
  ArtifactSpec spec;
  // The same by the CPU; of steps, which have no such parameter, the same spec.
  ArtifactSpec by_cpu;
};

// Of the light "light" and the receiver "receiver". `resolution` is that of the light's maps.
std::vector<GlSpec> GlSpecs(uint32_t resolution, uint32_t samples);

// A box and a ball over a floor of `texels`² texels, in the light of a rectangle.
SceneDelta BallOverFloor(uint32_t texels, int around = 24);
// The ball at another place.
SceneDelta BallAt(float x, int around = 24);

// The payload's numbers, byte by byte.
std::string BitsOf(const Artifact& artifact);

}  // namespace penumbra::testing
