#include "server/server_identity.h"
#include "server/service/penumbra_service.h"
#include "server/service/unary_call.h"

namespace penumbra {
namespace {

v1::ServerStatistics StatisticsOf(const ServiceParts& parts) {
  const ServerCounters& counters = parts.sessions.counters;
  const EngineStatistics engine = parts.engine.statistics();
  v1::ServerStatistics statistics;
  statistics.set_open_sessions(counters.open_sessions);
  statistics.set_open_subscriptions(counters.open_subscriptions);
  statistics.set_commits(counters.commits);
  statistics.set_artifacts_computed(engine.artifacts_published);
  statistics.set_jobs_started(engine.jobs_started);
  statistics.set_artifacts_encoded(counters.artifacts_encoded);
  statistics.set_updates_sent(counters.updates_sent);
  statistics.set_blobs(parts.sessions.blobs.blob_count());
  statistics.set_blob_bytes(parts.sessions.blobs.blob_bytes());
  return statistics;
}

}  // namespace

grpc::ServerUnaryReactor* PenumbraService::GetServerInfo(Context* context, const Bytes* request,
                                                         Bytes* response) {
  return AnswerUnary<v1::GetServerInfoRequest>(
      context, parts_, "GetServerInfo", request, response,
      [&](const v1::GetServerInfoRequest&,
          const Caller& caller) -> absl::StatusOr<v1::GetServerInfoResponse> {
        using std::chrono::duration_cast, std::chrono::milliseconds, std::chrono::steady_clock;
        v1::GetServerInfoResponse info;
        info.set_server_name(kServerName);
        info.add_protocol_versions(kProtocolVersion);
        *info.mutable_limits() = ToProto(parts_.sessions.limits);
        *info.mutable_gl() = parts_.gl_info();
        info.set_is_degraded(!info.gl().error().empty());
        info.set_thread_count(parts_.engine.cpu_threads());
        info.set_uptime_ms(
            duration_cast<milliseconds>(steady_clock::now() - parts_.started).count());
        // They count what others do, which is for those who may see all of it.
        if (caller.identity().scope.is_everything()) {
          *info.mutable_statistics() = StatisticsOf(parts_);
        }
        return info;
      });
}

}  // namespace penumbra
