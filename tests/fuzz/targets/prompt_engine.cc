#include "tests/fuzz/targets/prompt_engine.h"

#include <cstdint>
#include <utility>

#include "render/technique/technique.h"
#include "tests/fuzz/kit/require.h"

namespace penumbra::fuzzing {
namespace {

// Two tiles, of which commits change the first.
std::shared_ptr<const Artifact> SmallArtifact(const Scene& scene, const ArtifactSpec& spec) {
  constexpr uint32_t kWidth = 66, kHeight = 2;
  SoftShadowTexture texture;
  texture.visibility.width = kWidth;
  texture.visibility.height = kHeight;
  texture.visibility.sample_count = 1;
  texture.visibility.counts.assign(size_t{kWidth} * kHeight, 1);
  texture.visibility.counts[scene.revision() % kHeight] = 0;
  Artifact artifact;
  artifact.header.scene_id = scene.id();
  artifact.header.revision = scene.revision();
  artifact.header.scene_hash = scene.content_hash();
  artifact.header.technique = std::string(InfoOf(spec.params).name);
  artifact.header.light_id = spec.light_id;
  artifact.header.receiver_id = spec.receiver_id;
  artifact.header.is_final = true;
  artifact.payload = std::move(texture);
  return std::make_shared<const Artifact>(std::move(artifact));
}

}  // namespace

class PromptEngine::Ticket final : public SharedSubscription {
 public:
  Ticket(PromptEngine& engine, std::list<Follower>::iterator follower)
      : engine_(engine), follower_(follower) {}
  ~Ticket() override {
    Require(follower_->parties.empty(), "whoever has joined leaves");
    engine_.followers_.erase(follower_);
  }

  void Join(const Party& party) override { follower_->parties.insert(party); }
  void Leave(const Party& party) override {
    const auto joined = follower_->parties.find(party);
    Require(joined != follower_->parties.end(), "whoever leaves has joined");
    follower_->parties.erase(joined);
  }

 private:
  PromptEngine& engine_;
  const std::list<Follower>::iterator follower_;
};

absl::StatusOr<std::unique_ptr<SharedSubscription>> PromptEngine::SubscribeFor(
    const Party& party, const std::string& scene_id, const ArtifactSpec& spec,
    ArtifactCallback callback) {
  const auto scene = scenes_.Snapshot(scene_id);
  if (!scene.ok()) return scene.status();
  const absl::Status check = TechniqueFor(spec.params).Check(**scene, spec);
  if (absl::IsInvalidArgument(check)) return check;
  const auto follower =
      followers_.insert(followers_.end(), Follower{.spec = spec, .callback = std::move(callback)});
  std::unique_ptr<SharedSubscription> ticket = std::make_unique<Ticket>(*this, follower);
  ticket->Join(party);
  follower->Tell(**scene);
  return ticket;
}

void PromptEngine::Tell(const Scene& scene) {
  for (Follower& follower : followers_) follower.Tell(scene);
}

void PromptEngine::Follower::Tell(const Scene& scene) {
  constexpr Revision kOneOf = 4;  // commits cannot change it
  ArtifactUpdate update{.revision = scene.revision(),
                        .status = TechniqueFor(spec.params).Check(scene, spec),
                        .artifact = nullptr};
  if (update.status.ok()) {
    if (!newest || scene.revision() % kOneOf != 0) newest = SmallArtifact(scene, spec);
    update.artifact = newest;
  }
  callback(update);
}

}  // namespace penumbra::fuzzing
