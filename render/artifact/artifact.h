// What a technique makes and a client receives.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "render/artifact/soft_shadow_texture.h"
#include "render/scene/content_hash.h"
#include "render/scene/light_sample.h"
#include "render/scene/scene.h"

namespace penumbra {

struct ArtifactHeader {
  std::string scene_id;
  Revision revision = 0;   // of the scene that was computed on
  ContentHash scene_hash;  // of the same
  std::string technique;   // its name, "soft_texture"
  std::string light_id;
  std::string receiver_id;
  std::map<std::string, std::string> parameters;  // effective ones, as text
  std::vector<LightSample> light_samples;         // those counted so far, in order
  uint32_t samples_requested = 0;                 // how many the last pass will have counted
  uint32_t pass = 0;                              // 0 is the first, coarse one
  bool is_final = false;                          // no pass of this revision follows
  // Standard error to expect of a texel's visible fraction, in [0, 0.5]; 0 where the light needs
  // one sample only.
  float error_estimate = 0.0f;
  std::map<std::string, double> timings_ms;  // stage → wall time
};

// One alternative for each kind of artifact.
using ArtifactPayload = std::variant<SoftShadowTexture>;

struct Artifact {
  ArtifactHeader header;
  ArtifactPayload payload;
};

// The fraction of the light visible at `point`, in [0, 1]: the texel that holds the point's
// parallel projection onto the receiver, clamped to the grid. `normal` is not used by textures.
float Visibility(const Artifact& artifact, Vec3 point, Vec3 normal);

// Whether the centre of that texel lies on the receiver; elsewhere Visibility is that of a texel
// nearby, or 0.
bool Covers(const Artifact& artifact, Vec3 point);

}  // namespace penumbra
