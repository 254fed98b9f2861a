// Who artifacts are computed for, where several share an engine.
#pragma once

#include <compare>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "render/engine/engine.h"

namespace penumbra {

// A viewer of a scene, and on whose account. Any names; equal ones are the same.
struct Party {
  std::string principal;
  std::string viewer;  // one of the principal's

  friend auto operator<=>(const Party&, const Party&) = default;
};

// A subscription for several parties. Its jobs are done for all of them, and each bears its part of
// what they take; without any, an unnamed one does. A party that joins twice leaves twice.
class SharedSubscription : public Subscription {
 public:
  virtual void Join(const Party& party) = 0;
  virtual void Leave(const Party& party) = 0;
};

class SharedEngine {
 public:
  virtual ~SharedEngine() = default;

  // Engine::Subscribe, with `party` the first to join.
  virtual absl::StatusOr<std::unique_ptr<SharedSubscription>> SubscribeFor(
      const Party& party, const std::string& scene_id, const ArtifactSpec& spec,
      ArtifactCallback callback) = 0;
};

}  // namespace penumbra
