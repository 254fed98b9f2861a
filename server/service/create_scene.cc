#include <string>

#include "proto/convert/scene_convert.h"
#include "server/service/penumbra_service.h"
#include "server/service/unary_call.h"

namespace penumbra {

grpc::ServerUnaryReactor* PenumbraService::CreateScene(Context* context, const Bytes* request,
                                                       Bytes* response) {
  return AnswerUnaryOn<v1::CreateSceneRequest>(
      parts_.sessions.scenes.scenes_lane(), parts_, context, request, response,
      [this](const v1::CreateSceneRequest& message,
             const Caller& caller) -> absl::StatusOr<v1::CreateSceneResponse> {
        const std::string& name = caller.identity().name;
        const auto info = parts_.sessions.scenes.Create(
            message.scene_id(),
            {.name = name, .max_scenes = parts_.sessions.quotas.Of(name).scenes});
        if (!info.ok()) return info.status();
        v1::CreateSceneResponse created;
        *created.mutable_scene() = ToProto(*info);
        return created;
      });
}

}  // namespace penumbra
