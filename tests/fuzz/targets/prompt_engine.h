// An engine without threads: artifacts are there at once, and are of a few texels.
//
//   PromptEngine engine(scenes);                                         // which has the scenes
//   auto subscription = engine.SubscribeFor(party, "studio", spec, callback);  // calls it
//   engine.Tell(*scene);                                                 // again, after a commit
#pragma once

#include <cstddef>
#include <list>
#include <memory>
#include <set>
#include <string>

#include "absl/status/statusor.h"
#include "render/engine/engine.h"
#include "render/engine/party.h"

namespace penumbra::fuzzing {

// Of one thread. What a spec may ask for is checked as ever.
class PromptEngine final : public SharedEngine {
 public:
  explicit PromptEngine(Engine& scenes) : scenes_(scenes) {}

  absl::StatusOr<std::unique_ptr<SharedSubscription>> SubscribeFor(
      const Party& party, const std::string& scene_id, const ArtifactSpec& spec,
      ArtifactCallback callback) override;
  // There has been a commit to the one scene.
  void Tell(const Scene& scene);

  size_t subscription_count() const { return followers_.size(); }

 private:
  struct Follower {
    ArtifactSpec spec;
    ArtifactCallback callback;
    std::multiset<Party> parties{};
    std::shared_ptr<const Artifact> newest{};

    void Tell(const Scene& scene);
  };
  class Ticket;

  Engine& scenes_;
  std::list<Follower> followers_;
};

}  // namespace penumbra::fuzzing
