// What a technique makes and a client receives.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "render/artifact/attenuation_ldi.h"
#include "render/artifact/shadow_volume_mesh.h"
#include "render/artifact/shadow_width_map.h"
#include "render/artifact/soft_shadow_texture.h"
#include "render/artifact/view_shadow.h"
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
  std::string receiver_id;                        // empty where the technique takes none
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
using ArtifactPayload =
    std::variant<SoftShadowTexture, AttenuationLdi, ViewShadow, ShadowWidthMap, ShadowVolumeMesh>;

struct Artifact {
  ArtifactHeader header;
  ArtifactPayload payload;
};

// The texels of artifacts that are a grid of them; null for others.
const ShadowTexels* TexelsOf(const ArtifactPayload& payload);
ShadowTexels* TexelsOf(ArtifactPayload& payload);

// The light that the artifact is about.
const AreaLight& LightOf(const ArtifactPayload& payload);

// The fraction of the light visible at `point`, in [0, 1]. A texture has it at the texel that holds
// the point's parallel projection onto the receiver, clamped to the grid, a picture at the pixel
// where the camera sees the point, clamped to its part; `normal`, of length 1, is not used by
// either.
// Lightmaps and given points are not told apart by place: 0.
float Visibility(const Artifact& artifact, Vec3 point, Vec3 normal);

// Whether the centre of that texel or pixel is the receiver's, or a surface's; elsewhere Visibility
// is that of a texel nearby, or 0.
bool Covers(const Artifact& artifact, Vec3 point);

}  // namespace penumbra
