#include "render/scene/scene.h"
#include "server/service/penumbra_service.h"
#include "server/service/unary_call.h"

namespace penumbra {

grpc::ServerUnaryReactor* PenumbraService::DeleteScene(Context* context, const Bytes* request,
                                                       Bytes* response) {
  return AnswerUnaryOn<v1::DeleteSceneRequest>(
      parts_.sessions.scenes.scenes_lane(), parts_, context, request, response,
      [this](const v1::DeleteSceneRequest& message,
             const Caller&) -> absl::StatusOr<v1::DeleteSceneResponse> {
        if (auto status = CheckId(message.scene_id(), "scene_id"); !status.ok()) return status;
        if (auto status = parts_.sessions.scenes.Delete(message.scene_id()); !status.ok()) {
          return status;
        }
        return v1::DeleteSceneResponse();
      });
}

}  // namespace penumbra
