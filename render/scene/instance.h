// A placed mesh.
#pragma once

#include <memory>
#include <string>

#include "render/math/vec.h"
#include "render/scene/alpha_mask.h"
#include "render/scene/mesh.h"

namespace penumbra {

struct Instance {
  std::string id;  // [A-Za-z0-9._-], 1 to 128 bytes, unique among a scene's instances
  std::shared_ptr<const Mesh> mesh;
  // Any affine map: a mirror turns faces over, a scale of zero hides the instance.
  Affine world_from_mesh = IdentityAffine();
  bool casts = true;     // blocks light
  bool receives = true;  // may show shadows
  Vec3 color{0.8f};      // diffuse reflectance, linear RGB in [0, 1]; a thin client draws with it
  // Where the mask's opacity at the surface's uv is below the cutoff the surface is not there.
  std::shared_ptr<const AlphaMask> alpha_mask;  // null: opaque
  float alpha_cutoff = 0.5f;                    // [0, 1]

  friend bool operator==(const Instance&, const Instance&);
};

}  // namespace penumbra
