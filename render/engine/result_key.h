// What a final artifact depends on, as a name: two computations of the same name end in the same
// texels, whichever scene they are of.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <optional>

#include "render/artifact/artifact.h"
#include "render/scene/content_hash.h"
#include "render/scene/scene.h"
#include "render/scene/scene_hash.h"
#include "render/technique/artifact_spec.h"

namespace penumbra {

// Of the spec without its time budget, the lights that it names, its receiver, and all surfaces of
// the scene; for artifacts without a receiver, also of receivers that stand by themselves, which
// are surfaces to them. Colours, other lights and other receivers are left out.
// nullopt: the scene lacks something that the spec names.
std::optional<ContentHash> ResultKey(const Scene& scene, const ContentHash& surfaces,
                                     const ArtifactSpec& spec);

// Keys of many artifacts. Any thread may use it.
class ResultKeys {
 public:
  // Cost  that of HashOfSurfaces, once for a table of instances as long as a scene has it
  std::optional<ContentHash> Of(const Scene& scene, const ArtifactSpec& spec);

 private:
  ContentHash SurfacesOf(const Scene& scene);

  using Table = std::weak_ptr<const InstanceTable>;
  std::mutex mutex_;
  std::map<Table, ContentHash, std::owner_less<Table>> surfaces_;
};

// `found`, which has the key of `scene`, as if it had been computed on it: in one pass, without
// timings. Itself, where it was.
std::shared_ptr<const Artifact> AsComputedOn(const Scene& scene,
                                             std::shared_ptr<const Artifact> found);

}  // namespace penumbra
