// What a commit changed, as far as shadows go.
//
//   SceneChange change(*before, *after, delta);
//   if (change.Affects(spec, region)) …  // compute again
#pragma once

#include <optional>
#include <vector>

#include "render/math/aabb.h"
#include "render/scene/scene.h"
#include "render/scene/shadow_region.h"
#include "render/technique/artifact_spec.h"

namespace penumbra {

// Refers to its arguments: use it while they live. One thread at a time.
class SceneChange {
 public:
  // `after` is `before` with `delta` applied.
  SceneChange(const Scene& before, const Scene& after, const SceneDelta& delta);

  // False only if the artifact of `spec` is the same on both scenes: the light and the receiver's
  // place are as they were, and whatever was added, removed or changed its shape, its place or what
  // it lets through lies outside the region between light and receiver, before and after. A colour
  // changes no artifact, nor does a `receives` flag one of a receiver. Of techniques that compute
  // for all surfaces, or for points, every surface counts, wherever it is, and receivers that stand
  // by themselves are surfaces.
  bool Affects(const ArtifactSpec& spec, KnownShadowRegion& region);

 private:
  bool ChangesSurfaces() const;
  bool ChangesPatches() const;
  const std::vector<Aabb>& ChangedCasterBounds();

  const Scene& before_;
  const Scene& after_;
  const SceneDelta& delta_;
  std::optional<std::vector<Aabb>> changed_caster_bounds_;  // found when first asked for
};

}  // namespace penumbra
