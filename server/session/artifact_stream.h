// One artifact of one scene kept up to date and encoded, for all sessions that subscribe to it.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "render/engine/engine.h"
#include "render/engine/party.h"
#include "server/counters.h"
#include "server/session/delay_line.h"
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

// What streams share. It outlives them and the engine, whose threads run their callbacks.
struct StreamServices {
  // A studio of 84 boxes (256 × 256 texels, 64 samples) takes 1.2 ms on two threads, of which the
  // coarse pass is the first 0.3 ms. Whoever waits longer than that does not see 3 ms more.
  static constexpr std::chrono::milliseconds kHoldBack{3};

  explicit StreamServices(ServerCounters& server_counters) : counters(server_counters) {}

  ServerCounters& counters;
  ArtifactEncoder encoder;
  DelayLine hold_back{kHoldBack};
};

// The very first artifact goes out at once, however coarse. After that subscribers have something
// to show, and a coarse one is held back for a few milliseconds: when the final one is there by
// then, all its tiles would have travelled for nothing.
class ArtifactStream : public std::enable_shared_from_this<ArtifactStream> {
 public:
  explicit ArtifactStream(StreamServices& services) : services_(services) {}

  // Begins to follow the artifact for `party`, the first time that it is called; later calls wait
  // for that, and `party` joins. It is to leave once for each that was OK. Errors  those of
  // Engine::Subscribe
  absl::Status Start(SharedEngine& engine, const Party& party, const std::string& scene_id,
                     const ArtifactSpec& spec);
  void Leave(const Party& party);

  StreamState Latest() const;
  void AddListener(std::weak_ptr<StreamListener> listener);
  void RemoveListener(const StreamListener* listener);

 private:
  void OnUpdate(const ArtifactUpdate& update);
  void PublishHeldBack();
  void Publish(const ArtifactUpdate& update);  // with publishing_ locked

  StreamServices& services_;

  std::mutex starting_;
  std::optional<absl::Status> started_;

  std::mutex publishing_;  // one update at a time, in their order; taken before mutex_
  std::optional<ArtifactUpdate> held_back_;

  mutable std::mutex mutex_;
  StreamState state_;
  std::vector<std::weak_ptr<StreamListener>> listeners_;
  // Last, so that it is gone before what its callback uses.
  std::unique_ptr<SharedSubscription> subscription_;
};

// The streams that sessions follow now. Any thread may use it.
class StreamTable {
 public:
  StreamTable(SharedEngine& engine, StreamServices& services)
      : engine_(engine), services_(services) {}

  // The stream of `spec`, which lives as long as somebody holds it. `incarnation` is the scene's.
  // Its jobs are done for `party`, among others, until what is returned and its copies are gone.
  // Errors  those of Engine::Subscribe
  absl::StatusOr<std::shared_ptr<ArtifactStream>> Follow(const Party& party,
                                                         const std::string& scene_id,
                                                         const std::string& incarnation,
                                                         const ArtifactSpec& spec);

 private:
  SharedEngine& engine_;
  StreamServices& services_;
  std::mutex mutex_;
  std::map<std::pair<std::string, std::string>, std::weak_ptr<ArtifactStream>>
      streams_;  // by incarnation and SpecKey
};

}  // namespace penumbra
