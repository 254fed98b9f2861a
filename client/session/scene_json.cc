#include "client/session/scene_json.h"

#include "google/protobuf/util/json_util.h"
#include "proto/convert/scene_convert.h"
#include "render/scene/scene_difference.h"

namespace penumbra {

std::string SceneJson(const Scene& scene) {
  google::protobuf::util::JsonPrintOptions options;
  options.preserve_proto_field_names = true;
  options.always_print_primitive_fields = true;
  std::string json;
  const auto status = google::protobuf::util::MessageToJsonString(
      ToProto(Difference(*Scene::Empty(scene.id()), scene)), &json, options);
  return status.ok() ? json : "{}";
}

}  // namespace penumbra
