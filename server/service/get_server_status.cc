#include <map>
#include <string>

#include "server/server_identity.h"
#include "server/service/penumbra_service.h"
#include "server/service/server_statistics.h"
#include "server/service/unary_call.h"

namespace penumbra {
namespace {

// Tag and length of a list's entry.
constexpr size_t kEntryBytes = 8;

v1::SceneStatus ToProto(const LocalEngine::SceneLoad& load, uint64_t clients) {
  v1::SceneStatus status;
  status.set_scene_id(load.scene.id);
  status.set_revision(load.scene.revision);
  status.set_clients(clients);
  status.set_artifacts(load.artifacts);
  status.set_jobs_waiting(load.jobs_waiting);
  status.set_jobs_running(load.jobs_running);
  status.set_objects(load.scene.instance_count + load.scene.light_count +
                     load.scene.receiver_count);
  return status;
}

v1::ClientStatus ToProto(const SessionSummary& summary) {
  v1::ClientStatus status;
  status.set_session(summary.number);
  status.set_scene_id(summary.scene_id);
  status.set_client_name(summary.client_name);
  status.set_age_ms(static_cast<uint64_t>(summary.age.count()));
  status.set_subscriptions(summary.subscriptions);
  status.set_commits(summary.commits);
  status.set_updates_sent(summary.updates_sent);
  status.set_updates_skipped(summary.updates_skipped);
  status.set_sent_bytes(summary.sent_bytes);
  return status;
}

// Lists what fits into a message, and counts what does not.
class BoundedAnswer {
 public:
  BoundedAnswer(v1::GetServerStatusResponse& response, size_t max_bytes)
      : response_(response), room_(max_bytes - response.ByteSizeLong() - kEntryBytes) {}

  template <typename Entry>
  void Add(const Entry& entry, google::protobuf::RepeatedPtrField<Entry>& list) {
    const size_t bytes = entry.ByteSizeLong() + kEntryBytes;
    if (bytes > room_) return response_.set_left_out(response_.left_out() + 1);
    room_ -= bytes;
    *list.Add() = entry;
  }

 private:
  v1::GetServerStatusResponse& response_;
  size_t room_;
};

}  // namespace

grpc::ServerUnaryReactor* PenumbraService::GetServerStatus(Context* context, const Bytes* request,
                                                           Bytes* response) {
  return AnswerUnary<v1::GetServerStatusRequest>(
      parts_, context, request, response,
      [&](const v1::GetServerStatusRequest&,
          const Caller& caller) -> absl::StatusOr<v1::GetServerStatusResponse> {
        v1::GetServerStatusResponse status;
        status.set_server_name(kServerName);
        status.set_uptime_ms(UptimeMs(parts_));
        status.set_is_degraded(!parts_.gl_info().error().empty());
        // They count what others do, which is for those who may see all of it.
        if (caller.identity().scope.is_everything()) {
          *status.mutable_statistics() = StatisticsOf(parts_);
        }
        const auto sessions = parts_.sessions.ledger.List();
        std::map<std::string, uint64_t> clients;
        for (const SessionSummary& session : sessions) ++clients[session.scene_id];
        BoundedAnswer answer(status, parts_.sessions.limits.max_message_bytes);
        const SceneScope& scope = caller.identity().scope;
        for (const auto& load : parts_.engine.scene_loads()) {
          if (!scope.Contains(load.scene.id)) continue;
          answer.Add(ToProto(load, clients[load.scene.id]), *status.mutable_scenes());
        }
        for (const SessionSummary& session : sessions) {
          if (!scope.Contains(session.scene_id)) continue;
          answer.Add(ToProto(session), *status.mutable_clients());
        }
        return status;
      });
}

}  // namespace penumbra
