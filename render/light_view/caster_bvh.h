// The instances of a scene in Embree's hierarchies, for rays.
//
//   CasterBvhs known;
//   auto bvh = known.Of(scene);   // builds what is new, shares the rest
#pragma once

#include <cstddef>
#include <memory>
#include <stop_token>
#include <vector>

#include "absl/status/status.h"
#include "render/scene/scene.h"

struct RTCSceneTy;

namespace penumbra {

class CasterBvhStore;

// One hierarchy for each instance, as it is placed in single precision, and one over them; or one
// over the triangles of them all. Immutable: any thread may trace, any number at a time.
class CasterBvh {
 public:
  // Null: it is not whole.
  RTCSceneTy* embree() const { return top_.get(); }
  size_t triangle_count() const { return triangle_count_; }
  // Whether it is whole.
  //
  // Errors  kResourceExhausted: Embree ran out of memory; kCancelled: stop requested
  const absl::Status& status() const { return status_; }
  // What it takes besides its parts, which others may have too.
  size_t bytes() const { return own_bytes_; }

 private:
  friend class CasterBvhStore;

  CasterBvh() = default;

  std::vector<std::shared_ptr<const void>> parts_;  // outlive what is over them
  std::shared_ptr<RTCSceneTy> top_;
  size_t triangle_count_ = 0;
  size_t own_bytes_ = 0;
  absl::Status status_;
};

// The hierarchies of a scene, as one computation asks for them: when an instance moves, its own
// alone is built again. Any thread may ask.
class CasterBvhs {
 public:
  // Those that block light, or all that a camera sees.
  enum class Instances { kCasting, kAll };

  // `stop`   ends a build, and the wait for somebody else's
  // `store`  where they are found; null: one of its own, which keeps nothing that is not in use
  explicit CasterBvhs(std::stop_token stop = {}, std::shared_ptr<CasterBvhStore> store = nullptr);

  // Of what could not be built status() says why.
  //
  // Cost  what is new: about 0.2 s and 0.1 GB for a million triangles on two threads
  std::shared_ptr<const CasterBvh> Of(const Scene& scene,
                                      Instances which = Instances::kCasting) const;
  // One hierarchy over the triangles of all that casts, for many rays: up to half of their time is
  // saved where instances are many, a quarter by Embree's quicker tests, by which a ray in millions
  // may pass between two triangles, and queries may have filters of their own.
  //
  // Cost  as if all were new, after any edit of what casts
  std::shared_ptr<const CasterBvh> Flat(const Scene& scene) const;

  // Hierarchies over triangles that the store has built.
  size_t built() const;

 private:
  std::stop_token stop_;
  std::shared_ptr<CasterBvhStore> store_;
};

}  // namespace penumbra
