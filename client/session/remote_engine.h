// Computes on a server.
//
//   auto engine = RemoteEngine::Connect({.address = "localhost:7447"});
//   if (!engine.ok()) return engine.status();  // "localhost:7447: no server answers: …"
//   (*engine)->Commit("studio", delta);         // the same interface as LocalEngine
//
// Each scene in use has one Session stream, a mirror of its content, and a few threads that take
// turns to read the stream: whoever has read an update hands the reading on and runs the callback,
// so that no hop lies between the wire and the callback, and no slow callback keeps commits or
// other subscriptions waiting. A callback slower than the updates misses those in between.
//
// When the connection breaks, a session is resumed on another one: commits under way are sent again
// under the key that makes them one, subscriptions go on, and the mirror hears what it has missed.
// What cannot be resumed within `reconnect_for_s` ends with kUnavailable. Later calls connect anew.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/session/client_credentials.h"
#include "client/session/traffic.h"
#include "render/engine/engine.h"

namespace penumbra {

class ServerConnection;

// What becomes of a scene's connection.
struct ConnectionEvent {
  enum class Kind { kLost, kRestored, kGivenUp };
  Kind kind = Kind::kLost;
  std::string scene_id;
  absl::Status reason;          // why it was lost, or given up
  int attempts = 0;             // to connect, so far
  bool missed_nothing = false;  // restored: what has changed meanwhile was told in small
};

struct RemoteEngineOptions {
  std::string address;                   // "host:port"
  std::string client_name = "penumbra";  // for the server's log
  double connect_timeout_s = 5.0;
  // For the answer to anything but an artifact. A large upload has as long for each 16 MiB.
  double call_timeout_s = 30.0;
  // How long a session that has lost its connection tries to get another one; 0: not at all.
  double reconnect_for_s = 30.0;
  // Told of that, on a thread of the session's; may be null.
  std::function<void(const ConnectionEvent&)> on_connection = nullptr;
  // Told while meshes are being uploaded, on the thread that commits; may be null.
  std::function<void(uint64_t sent_bytes, uint64_t total_bytes)> upload_progress = nullptr;
  ClientCredentials credentials{};
};

// Which shadows are asked for at once: of each light on each receiver, or for whatever else the
// technique computes.
struct EachRequest {
  TechniqueParams params;
  std::vector<std::string> light_ids;                  // empty: all that the scene has now
  std::vector<std::string> receiver_ids;               // likewise, of techniques for receivers
  std::optional<PointReceiver> points = std::nullopt;  // of techniques for points
};

struct EachSubscription {
  ArtifactSpec spec;
  std::unique_ptr<Subscription> subscription;
};

class RemoteEngine : public Engine {
 public:
  // Errors  kUnavailable: no server at that address, or none that answers in time;
  //         kUnauthenticated: one that does not accept the credentials; kInvalidArgument:
  //         credentials that cannot be shown there (channel_credentials.h)
  static absl::StatusOr<std::unique_ptr<RemoteEngine>> Connect(RemoteEngineOptions options);

  // Ends all sessions and waits for the callbacks that run. Subscriptions may be destroyed before
  // or after.
  ~RemoteEngine() override;

  absl::Status CreateScene(const std::string& scene_id) override;
  absl::Status DeleteScene(const std::string& scene_id) override;
  absl::StatusOr<std::vector<SceneInfo>> ListScenes() override;
  // Uploads what the server lacks of the delta's meshes and masks, then commits.
  absl::StatusOr<Revision> Commit(const std::string& scene_id, const SceneDelta& delta) override;
  // Fetches the meshes that other clients have brought in, where the mirror has not seen them.
  absl::StatusOr<std::shared_ptr<const Scene>> Snapshot(const std::string& scene_id) override;
  absl::StatusOr<std::unique_ptr<Subscription>> Subscribe(const std::string& scene_id,
                                                          const ArtifactSpec& spec,
                                                          ArtifactCallback callback) override;

  // The same as Subscribe, with what each update took on the wire.
  using MeasuredCallback = std::function<void(const ArtifactUpdate&, const UpdateTraffic&)>;
  absl::StatusOr<std::unique_ptr<Subscription>> SubscribeMeasured(const std::string& scene_id,
                                                                  const ArtifactSpec& spec,
                                                                  MeasuredCallback callback);

  // The server knows one viewer for each engine and scene: the last view reported counts.
  absl::Status ReportView(const std::string& scene_id, const std::string& viewer,
                          const std::optional<View>& view) override;

  // One subscription for each of some lights on each of some receivers, by one request: all of them
  // or none, receiver by receiver. Callbacks of different ones may run at the same time.
  //
  // Errors  kNotFound UNKNOWN_ID: a light or receiver that the scene lacks; kInvalidArgument;
  //         kResourceExhausted QUOTA_SUBSCRIPTIONS, QUOTA_ARTIFACTS: more than the server keeps
  using EachCallback =
      std::function<void(const ArtifactSpec&, const ArtifactUpdate&, const UpdateTraffic&)>;
  absl::StatusOr<std::vector<EachSubscription>> SubscribeEach(const std::string& scene_id,
                                                              const EachRequest& request,
                                                              EachCallback callback);

  // What the server says of itself, of what goes on, and of its techniques: GetServerInfoResponse,
  // GetServerStatusResponse and ListTechniquesResponse in protobuf's JSON, with the fields named as
  // in the protocol.
  absl::StatusOr<std::string> ServerInfoJson();
  absl::StatusOr<std::string> ServerStatusJson();
  absl::StatusOr<std::string> TechniquesJson();

  UploadTraffic upload_traffic() const;

 private:
  explicit RemoteEngine(std::unique_ptr<ServerConnection> connection);

  const std::unique_ptr<ServerConnection> connection_;
};

}  // namespace penumbra
