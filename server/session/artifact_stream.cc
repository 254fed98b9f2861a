#include "server/session/artifact_stream.h"

#include <new>
#include <utility>

namespace penumbra {
namespace {

// One party's part in a stream.
struct Stake {
  Stake(std::shared_ptr<ArtifactStream> of, Party whose)
      : stream(std::move(of)), party(std::move(whose)) {}
  ~Stake() { stream->Leave(party); }

  const std::shared_ptr<ArtifactStream> stream;
  const Party party;
};

}  // namespace

absl::Status ArtifactStream::Start(SharedEngine& engine, const Party& party,
                                   const std::string& scene_id, const ArtifactSpec& spec) {
  std::lock_guard lock(starting_);
  if (started_) {
    if (started_->ok()) subscription_->Join(party);
    return *started_;
  }
  auto subscription = engine.SubscribeFor(party, scene_id, spec,
                                          [weak = weak_from_this()](const ArtifactUpdate& update) {
                                            // Held during the call: a listener may drop the last
                                            // other owner.
                                            if (const auto stream = weak.lock())
                                              stream->OnUpdate(update);
                                          });
  started_ = subscription.status();
  if (subscription.ok()) subscription_ = *std::move(subscription);
  return *started_;
}

void ArtifactStream::Leave(const Party& party) { subscription_->Leave(party); }

StreamState ArtifactStream::Latest() const {
  std::lock_guard lock(mutex_);
  return state_;
}

void ArtifactStream::AddListener(std::weak_ptr<StreamListener> listener) {
  std::lock_guard lock(mutex_);
  std::erase_if(listeners_, [](const auto& weak) { return weak.expired(); });
  listeners_.push_back(std::move(listener));
}

void ArtifactStream::RemoveListener(const StreamListener* listener) {
  std::lock_guard lock(mutex_);
  for (auto it = listeners_.begin(); it != listeners_.end(); ++it) {
    if (it->lock().get() != listener) continue;
    listeners_.erase(it);
    return;
  }
}

void ArtifactStream::OnUpdate(const ArtifactUpdate& update) {
  const bool is_coarse = update.artifact && !update.artifact->header.is_final;
  std::lock_guard lock(publishing_);
  if (!is_coarse || !Latest().artifact) {
    held_back_.reset();
    Publish(update);
    return;
  }
  // A later coarse one takes the place of an earlier, but does not wait for longer.
  const bool is_waiting = held_back_.has_value();
  held_back_ = update;
  if (is_waiting) return;
  services_.hold_back.Post([weak = weak_from_this()] {
    if (const auto stream = weak.lock()) stream->PublishHeldBack();
  });
}

void ArtifactStream::PublishHeldBack() {
  std::lock_guard lock(publishing_);
  if (const auto update = std::exchange(held_back_, std::nullopt)) Publish(*update);
}

void ArtifactStream::Publish(const ArtifactUpdate& update) {
  const StreamState before = Latest();
  auto artifact = before.artifact;
  absl::Status status = update.status;
  if (update.artifact && (!artifact || artifact->artifact != update.artifact)) {
    const uint64_t sequence = artifact ? artifact->sequence + 1 : 1;
    const auto start = std::chrono::steady_clock::now();
    try {
      artifact = services_.encoder.Encode(artifact.get(), update.artifact, sequence);
      ++services_.counters.artifacts_encoded;
      const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
      services_.counters.encode_seconds.Observe(took.count());
    } catch (const std::bad_alloc&) {
      status = absl::ResourceExhaustedError("out of memory for the encoded artifact");
    }
  }
  std::vector<std::shared_ptr<StreamListener>> listeners;
  {
    std::lock_guard lock(mutex_);
    state_ = {.number = before.number + 1,
              .revision = update.revision,
              .status = std::move(status),
              .artifact = std::move(artifact)};
    for (const auto& weak : listeners_) {
      if (auto listener = weak.lock()) listeners.push_back(std::move(listener));
    }
  }
  for (const auto& listener : listeners) listener->OnStreamChanged();
}

absl::StatusOr<std::shared_ptr<ArtifactStream>> StreamTable::Follow(const Party& party,
                                                                    const std::string& scene_id,
                                                                    const std::string& incarnation,
                                                                    const ArtifactSpec& spec) {
  std::shared_ptr<ArtifactStream> stream;
  {
    std::lock_guard lock(mutex_);
    std::erase_if(streams_, [](const auto& entry) { return entry.second.expired(); });
    auto& slot = streams_[{incarnation, SpecKey(spec)}];
    stream = slot.lock();
    if (!stream) slot = stream = std::make_shared<ArtifactStream>(services_);
  }
  // Before the start: what comes of it is not what was there.
  const bool is_computed = stream->Latest().artifact != nullptr;
  // Without the table's lock: a commit to this scene may be under way, which others need not await.
  if (auto status = stream->Start(engine_, party, scene_id, spec); !status.ok()) return status;
  ++(is_computed ? services_.counters.cache_hits : services_.counters.cache_misses);
  const auto stake = std::make_shared<Stake>(std::move(stream), party);
  return std::shared_ptr<ArtifactStream>(stake, stake->stream.get());
}

}  // namespace penumbra
