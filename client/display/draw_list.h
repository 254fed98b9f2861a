// What is to be drawn, worked out without GL: each surface with the artifacts that may lie on it,
// and what glows.
//
//   DrawList list = BuildDrawList(scene, artifacts, /*draws_lights=*/true);
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "client/display/form_factor_glsl.h"
#include "client/display/visibility_glsl.h"
#include "render/artifact/artifact.h"
#include "render/math/aabb.h"
#include "render/scene/scene.h"

namespace penumbra {

// An artifact that may lie on a surface, as the shader reads it.
struct Candidate {
  uint32_t light = 0;     // index into DrawList::lights
  uint32_t receiver = 0;  // index into DrawList::receivers, with kIsTheReceiver or kIsPartOfIt
};

struct DrawItem {
  std::shared_ptr<const Mesh> mesh;
  Affine world_from_mesh = IdentityAffine();
  Aabb bounds;               // world space
  float depth_scale = 1.0f;  // below 1: behind other surfaces at the same place
  bool glows = false;
  Vec3 color{1.0f};       // reflectance, or radiance if it glows
  bool two_sided = true;  // of what glows
  std::shared_ptr<const AlphaMask> alpha_mask;
  float alpha_cutoff = 0.5f;
  bool receives = true;
  uint32_t first_candidate = 0;  // into DrawList::candidates, in the order of lights
  uint32_t end_candidate = 0;
};

struct DrawList {
  std::vector<DrawItem> items;
  std::vector<GpuLight> lights;  // in the order of the scene's
  std::vector<GpuReceiver> receivers;
  std::vector<std::shared_ptr<const Artifact>> artifacts;  // one a receiver, whose counts it wants
  std::vector<Candidate> candidates;
  // Artifacts that are not of a receiver, with their light: what they say of surfaces is found by
  // place.
  std::vector<std::pair<uint32_t, std::shared_ptr<const Artifact>>> of_any_surface;
  size_t texel_count = 0;  // places of all artifacts' counts and masks (PlacesOf)
};

DrawList BuildDrawList(const Scene& scene,
                       std::span<const std::shared_ptr<const Artifact>> artifacts,
                       bool draws_lights);

}  // namespace penumbra
