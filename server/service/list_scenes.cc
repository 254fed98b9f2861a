#include <map>
#include <string>
#include <utility>

#include "proto/convert/geometry_convert.h"
#include "proto/convert/scene_convert.h"
#include "server/service/penumbra_service.h"
#include "server/service/unary_call.h"

namespace penumbra {

grpc::ServerUnaryReactor* PenumbraService::ListScenes(Context* context, const Bytes* request,
                                                      Bytes* response) {
  return AnswerUnary<v1::ListScenesRequest>(
      parts_, context, request, response,
      [&](const v1::ListScenesRequest&,
          const Caller& caller) -> absl::StatusOr<v1::ListScenesResponse> {
        const auto infos = parts_.sessions.scenes.List();
        if (!infos.ok()) return infos.status();
        v1::ListScenesResponse list;
        std::map<std::string, v1::SceneInfo> scenes;
        for (const auto& [id, status] : parts_.sessions.scenes.Refused()) {
          scenes[id].set_scene_id(id);
          scenes[id].set_content_hash(ToProto(ContentHash()));
          scenes[id].set_damage(std::string(status.message()));
        }
        for (const SceneInfo& info : *infos) scenes[info.id] = ToProto(info);
        for (auto& [id, info] : scenes) {
          if (caller.identity().scope.Contains(id)) *list.add_scenes() = std::move(info);
        }
        return list;
      });
}

}  // namespace penumbra
