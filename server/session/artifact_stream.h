// One artifact of one scene kept up to date and encoded, for all sessions that subscribe to it.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "render/engine/engine.h"
#include "server/counters.h"
#include "server/session/encoded_artifact.h"

namespace penumbra {

// Told that a stream has something new. Called on the engine's threads; must not block.
class StreamListener {
 public:
  virtual ~StreamListener() = default;
  virtual void OnStreamChanged() = 0;
};

// What a stream says at one moment.
struct StreamState {
  uint64_t number = 0;  // grows with every change; 0: nothing yet
  Revision revision = 0;
  absl::Status status;                              // why there is no artifact at `revision`
  std::shared_ptr<const EncodedArtifact> artifact;  // the newest, which may be older than an error
};

class ArtifactStream : public std::enable_shared_from_this<ArtifactStream> {
 public:
  ArtifactStream(ArtifactEncoder& encoder, ServerCounters& counters)
      : encoder_(encoder), counters_(counters) {}

  // Begins to follow the artifact. Once, before anything else.
  // Errors  those of Engine::Subscribe
  absl::Status Start(Engine& engine, const std::string& scene_id, const ArtifactSpec& spec);

  StreamState Latest() const;
  void AddListener(std::weak_ptr<StreamListener> listener);
  void RemoveListener(const StreamListener* listener);

 private:
  void OnUpdate(const ArtifactUpdate& update);  // one call at a time

  ArtifactEncoder& encoder_;
  ServerCounters& counters_;

  mutable std::mutex mutex_;
  StreamState state_;
  std::vector<std::weak_ptr<StreamListener>> listeners_;
  // Last, so that it is gone before what its callback uses.
  std::unique_ptr<Subscription> subscription_;
};

// The streams that sessions follow now. Any thread may use it.
class StreamTable {
 public:
  StreamTable(Engine& engine, ServerCounters& counters) : engine_(engine), counters_(counters) {}

  // The stream of `spec`, which lives as long as somebody holds it. `incarnation` is the scene's.
  // Errors  those of Engine::Subscribe
  absl::StatusOr<std::shared_ptr<ArtifactStream>> Follow(const std::string& scene_id,
                                                         uint64_t incarnation,
                                                         const ArtifactSpec& spec);

 private:
  Engine& engine_;
  ServerCounters& counters_;
  ArtifactEncoder encoder_;
  std::mutex mutex_;
  std::map<std::pair<uint64_t, std::string>, std::weak_ptr<ArtifactStream>>
      streams_;  // by incarnation and SpecKey
};

}  // namespace penumbra
