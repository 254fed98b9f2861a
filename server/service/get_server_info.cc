#include "server/server_identity.h"
#include "server/service/penumbra_service.h"
#include "server/service/server_statistics.h"
#include "server/service/unary_call.h"

namespace penumbra {
grpc::ServerUnaryReactor* PenumbraService::GetServerInfo(Context* context, const Bytes* request,
                                                         Bytes* response) {
  return AnswerUnary<v1::GetServerInfoRequest>(
      parts_, context, request, response,
      [&](const v1::GetServerInfoRequest&,
          const Caller& caller) -> absl::StatusOr<v1::GetServerInfoResponse> {
        v1::GetServerInfoResponse info;
        info.set_server_name(kServerName);
        info.add_protocol_versions(kProtocolVersion);
        *info.mutable_limits() = ToProto(parts_.sessions.limits);
        *info.mutable_gl() = parts_.gl_info();
        info.set_is_degraded(!info.gl().error().empty());
        info.set_thread_count(parts_.engine.cpu_threads());
        info.set_uptime_ms(UptimeMs(parts_));
        // They count what others do, which is for those who may see all of it.
        if (caller.identity().scope.is_everything()) {
          *info.mutable_statistics() = StatisticsOf(parts_);
        }
        return info;
      });
}

}  // namespace penumbra
