#include "proto/convert/scene_convert.h"
#include "server/service/penumbra_service.h"
#include "server/service/unary_call.h"

namespace penumbra {

grpc::ServerUnaryReactor* PenumbraService::ListScenes(Context* context, const Bytes* request,
                                                      Bytes* response) {
  return AnswerUnary<v1::ListScenesRequest>(
      context, parts_, "ListScenes", request, response,
      [&](const v1::ListScenesRequest&,
          const Caller& caller) -> absl::StatusOr<v1::ListScenesResponse> {
        const auto infos = parts_.sessions.scenes.List();
        if (!infos.ok()) return infos.status();
        v1::ListScenesResponse list;
        for (const SceneInfo& info : *infos) {
          if (caller.identity().scope.Contains(info.id)) *list.add_scenes() = ToProto(info);
        }
        return list;
      });
}

}  // namespace penumbra
