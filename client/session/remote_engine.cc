#include "client/session/remote_engine.h"

#include <chrono>
#include <utility>

#include "client/session/archive_transfer.h"
#include "client/session/attendance_book.h"
#include "client/session/scene_presence.h"
#include "client/session/scene_session.h"
#include "client/session/server_connection.h"
#include "google/protobuf/util/json_util.h"
#include "proto/convert/scene_convert.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

std::string ToJson(const google::protobuf::Message& message) {
  google::protobuf::util::JsonPrintOptions options;
  options.preserve_proto_field_names = true;
  options.always_print_primitive_fields = true;
  std::string json;
  const auto status = google::protobuf::util::MessageToJsonString(message, &json, options);
  return status.ok() ? json : "{}";
}

bool MeansSceneIsGone(const absl::Status& status) {
  return absl::IsNotFound(status) && ErrorFieldPath(status) == "scene_id";
}

// What `request` makes of the scene's session. A session learns of its scene's deletion some time
// after it, so a request that it answers with that is made once more, on the session of the scene
// that has the id by now, as if it had been made after the deletion.
template <typename Request>
auto OnSession(ServerConnection& connection, const std::string& scene_id, const Request& request)
    -> decltype(request(std::declval<SceneSession&>())) {
  const auto session = connection.SessionOf(scene_id);
  if (!session.ok()) return session.status();
  auto result = request(**session);
  if (!MeansSceneIsGone(result.status())) return result;
  connection.EndSessionOfDeleted(scene_id, *session);
  const auto next = connection.SessionOf(scene_id);
  if (!next.ok()) return next.status();
  return request(**next);
}

}  // namespace

absl::StatusOr<std::unique_ptr<RemoteEngine>> RemoteEngine::Connect(RemoteEngineOptions options) {
  auto connection = ServerConnection::Open(std::move(options));
  if (!connection.ok()) return connection.status();
  return std::unique_ptr<RemoteEngine>(new RemoteEngine(*std::move(connection)));
}

RemoteEngine::RemoteEngine(std::unique_ptr<ServerConnection> connection)
    : connection_(std::move(connection)) {}

RemoteEngine::~RemoteEngine() = default;

absl::Status RemoteEngine::CreateScene(const std::string& scene_id) {
  v1::CreateSceneRequest request;
  request.set_scene_id(scene_id);
  v1::CreateSceneResponse response;
  // A session from before the scene was created is one on a scene of the same id that is gone, of
  // which its stream need not have told yet.
  const auto session = connection_->FindSession(scene_id);
  const absl::Status status =
      connection_->Call(&v1::PenumbraService::Stub::CreateScene, request, &response);
  if (status.ok()) connection_->EndSessionOfDeleted(scene_id, session);
  return status;
}

absl::Status RemoteEngine::DeleteScene(const std::string& scene_id) {
  v1::DeleteSceneRequest request;
  request.set_scene_id(scene_id);
  v1::DeleteSceneResponse response;
  const auto session = connection_->FindSession(scene_id);
  const absl::Status status =
      connection_->Call(&v1::PenumbraService::Stub::DeleteScene, request, &response);
  if (status.ok()) connection_->EndSessionOfDeleted(scene_id, session);
  return status;
}

absl::StatusOr<std::vector<SceneInfo>> RemoteEngine::ListScenes() {
  v1::ListScenesResponse response;
  const absl::Status status =
      connection_->Call(&v1::PenumbraService::Stub::ListScenes, v1::ListScenesRequest(), &response);
  if (!status.ok()) return status;
  std::vector<SceneInfo> infos;
  for (const v1::SceneInfo& proto : response.scenes()) {
    auto info = FromProto(proto);
    if (!info.ok()) return info.status();
    infos.push_back(*std::move(info));
  }
  return infos;
}

absl::StatusOr<Revision> RemoteEngine::Commit(const std::string& scene_id,
                                              const SceneDelta& delta) {
  return OnSession(*connection_, scene_id,
                   [&](SceneSession& session) { return session.Commit(delta); });
}

absl::StatusOr<std::shared_ptr<const Scene>> RemoteEngine::Snapshot(const std::string& scene_id) {
  return OnSession(*connection_, scene_id,
                   [](SceneSession& session) { return session.Snapshot(); });
}

absl::StatusOr<std::unique_ptr<Subscription>> RemoteEngine::Subscribe(const std::string& scene_id,
                                                                      const ArtifactSpec& spec,
                                                                      ArtifactCallback callback) {
  return SubscribeMeasured(
      scene_id, spec,
      [callback = std::move(callback)](const ArtifactUpdate& update, const UpdateTraffic&) {
        callback(update);
      });
}

absl::StatusOr<std::unique_ptr<Subscription>> RemoteEngine::SubscribeMeasured(
    const std::string& scene_id, const ArtifactSpec& spec, MeasuredCallback callback) {
  return OnSession(*connection_, scene_id,
                   [&](SceneSession& session) { return session.Subscribe(spec, callback); });
}

absl::Status RemoteEngine::ReportView(const std::string& scene_id, const std::string& /*viewer*/,
                                      const std::optional<View>& view) {
  const auto session = connection_->SessionOf(scene_id);
  if (!session.ok()) return session.status();
  return (*session)->ReportView(view);
}

absl::StatusOr<std::vector<EachSubscription>> RemoteEngine::SubscribeEach(
    const std::string& scene_id, const EachRequest& request, EachCallback callback) {
  return OnSession(*connection_, scene_id,
                   [&](SceneSession& session) { return session.SubscribeEach(request, callback); });
}

absl::StatusOr<std::unique_ptr<ScenePresence>> RemoteEngine::Enter(const std::string& scene_id,
                                                                   const Presence& presence,
                                                                   PresenceCallback changed) {
  const PresenceLimits& limits = connection_->presence_limits();
  if (auto status = CheckPresence(presence, limits); !status.ok()) return status;
  const SessionEntry entry{ToProto(presence), std::move(changed)};
  const auto session = connection_->EnteredSessionOf(scene_id, entry);
  if (!session.ok()) return session.status();
  const auto entered = (*session)->presence();
  auto handle = std::make_unique<ScenePresence>(*session, entered, limits);
  const std::chrono::duration<double> timeout(connection_->options().call_timeout_s);
  if (auto status = entered->AwaitList(timeout); !status.ok()) return status;
  return handle;
}

absl::StatusOr<std::string> RemoteEngine::ServerInfoJson() {
  v1::GetServerInfoResponse response;
  const absl::Status status = connection_->Call(&v1::PenumbraService::Stub::GetServerInfo,
                                                v1::GetServerInfoRequest(), &response);
  if (!status.ok()) return status;
  return ToJson(response);
}

absl::StatusOr<std::string> RemoteEngine::ServerStatusJson() {
  v1::GetServerStatusResponse response;
  const absl::Status status = connection_->Call(&v1::PenumbraService::Stub::GetServerStatus,
                                                v1::GetServerStatusRequest(), &response);
  if (!status.ok()) return status;
  return ToJson(response);
}

absl::StatusOr<std::string> RemoteEngine::TechniquesJson() {
  v1::ListTechniquesResponse response;
  const absl::Status status = connection_->Call(&v1::PenumbraService::Stub::ListTechniques,
                                                v1::ListTechniquesRequest(), &response);
  if (!status.ok()) return status;
  return ToJson(response);
}

absl::StatusOr<std::string> RemoteEngine::ScenesJson() {
  v1::ListScenesResponse response;
  const absl::Status status =
      connection_->Call(&v1::PenumbraService::Stub::ListScenes, v1::ListScenesRequest(), &response);
  if (!status.ok()) return status;
  return ToJson(response);
}

absl::Status RemoteEngine::ExportScene(const std::string& scene_id,
                                       const std::filesystem::path& file,
                                       const ArchiveOptions& options) {
  return ArchiveTransfer(*connection_, options).Export(scene_id, file);
}

absl::StatusOr<SceneInfo> RemoteEngine::ImportScene(const std::filesystem::path& file,
                                                    const std::string& scene_id,
                                                    const ArchiveOptions& options) {
  return ArchiveTransfer(*connection_, options).Import(file, scene_id);
}

UploadTraffic RemoteEngine::upload_traffic() const { return connection_->blobs().traffic(); }

}  // namespace penumbra
