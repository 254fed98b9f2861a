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
// Whoever was seen introduces themselves again, and edits on if they did.
// What cannot be resumed within `reconnect_for_s` ends with kUnavailable. Later calls connect anew.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/session/archive_options.h"
#include "client/session/presence.h"
#include "client/session/remote_engine_options.h"
#include "client/session/traffic.h"
#include "render/engine/engine.h"

namespace penumbra {

class ScenePresence;
class ServerConnection;

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

  // Lets the others in a scene see the user, and the user them (scene_presence.h). `changed` is
  // called with who is here, first and whenever that changes, on a thread of the session's, one
  // call at a time, the first perhaps before Enter has returned; it may be null. One presence for
  // each engine and scene. A session that is in use already goes on on another connection.
  //
  // Errors  those of CheckPresence; kAlreadyExists ALREADY_PRESENT; kNotFound: no such scene;
  //         kUnavailable
  absl::StatusOr<std::unique_ptr<ScenePresence>> Enter(const std::string& scene_id,
                                                       const Presence& presence,
                                                       PresenceCallback changed);

  // What the server says of itself, of what goes on, and of its techniques: GetServerInfoResponse,
  // GetServerStatusResponse and ListTechniquesResponse in protobuf's JSON, with the fields named as
  // in the protocol.
  absl::StatusOr<std::string> ServerInfoJson();
  absl::StatusOr<std::string> ServerStatusJson();
  absl::StatusOr<std::string> TechniquesJson();

  // ListScenesResponse, likewise.
  absl::StatusOr<std::string> ScenesJson();

  // Writes an archive of the scene: there is all of the file afterwards, or nothing of it.
  // Errors  those of the server; kUnavailable: the file cannot be written
  absl::Status ExportScene(const std::string& scene_id, const std::filesystem::path& file,
                           const ArchiveOptions& options = {});
  // Makes a scene of an archive, under its own id where `scene_id` is empty. What the server lacks
  // of its blobs is uploaded before. Errors  those of ReadArchive; those of the server
  absl::StatusOr<SceneInfo> ImportScene(const std::filesystem::path& file,
                                        const std::string& scene_id = {},
                                        const ArchiveOptions& options = {});

  UploadTraffic upload_traffic() const;

 private:
  explicit RemoteEngine(std::unique_ptr<ServerConnection> connection);

  const std::unique_ptr<ServerConnection> connection_;
};

}  // namespace penumbra
