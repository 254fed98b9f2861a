#include "proto/convert/scene_convert.h"

#include <string>
#include <utility>

#include "proto/convert/geometry_convert.h"
#include "proto/convert/light_convert.h"

namespace penumbra {
namespace {

std::string ElementPath(const char* list, int index) {
  return std::string(list) + "[" + std::to_string(index) + "]";
}

// Cuts a delta into messages of bounded size.
class Pieces {
 public:
  explicit Pieces(size_t max_bytes) : max_bytes_(max_bytes), pieces_(1) {}

  // The piece that has room for `bytes` more.
  v1::SceneDelta& For(size_t bytes) {
    constexpr size_t kFieldOverhead = 8;  // tag and length
    if (used_ > 0 && used_ + bytes + kFieldOverhead > max_bytes_) {
      pieces_.emplace_back();
      used_ = 0;
    }
    used_ += bytes + kFieldOverhead;
    return pieces_.back();
  }

  std::vector<v1::SceneDelta> Take() { return std::move(pieces_); }

 private:
  size_t max_bytes_;
  size_t used_ = 0;
  std::vector<v1::SceneDelta> pieces_;
};

}  // namespace

v1::SceneDelta ToProto(const SceneDelta& delta) {
  v1::SceneDelta proto;
  if (delta.base_revision) proto.set_base_revision(*delta.base_revision);
  for (const auto& instance : delta.upsert_instances) {
    *proto.add_upsert_instances() = ToProto(instance);
  }
  for (const auto& id : delta.remove_instances) proto.add_remove_instances(id);
  for (const auto& light : delta.upsert_lights) *proto.add_upsert_lights() = ToProto(light);
  for (const auto& id : delta.remove_lights) proto.add_remove_lights(id);
  for (const auto& receiver : delta.upsert_receivers) {
    *proto.add_upsert_receivers() = ToProto(receiver);
  }
  for (const auto& id : delta.remove_receivers) proto.add_remove_receivers(id);
  if (delta.receive_on_planar_surfaces) {
    *proto.mutable_receive_on_planar_surfaces() = ToProto(*delta.receive_on_planar_surfaces);
  }
  return proto;
}

std::vector<v1::SceneDelta> ToProtoPieces(const SceneDelta& delta, size_t max_bytes) {
  Pieces pieces(max_bytes);
  for (const auto& id : delta.remove_receivers) pieces.For(id.size()).add_remove_receivers(id);
  for (const auto& id : delta.remove_instances) pieces.For(id.size()).add_remove_instances(id);
  for (const auto& id : delta.remove_lights) pieces.For(id.size()).add_remove_lights(id);
  for (const auto& instance : delta.upsert_instances) {
    auto proto = ToProto(instance);
    *pieces.For(proto.ByteSizeLong()).add_upsert_instances() = std::move(proto);
  }
  for (const auto& light : delta.upsert_lights) {
    auto proto = ToProto(light);
    *pieces.For(proto.ByteSizeLong()).add_upsert_lights() = std::move(proto);
  }
  for (const auto& receiver : delta.upsert_receivers) {
    auto proto = ToProto(receiver);
    *pieces.For(proto.ByteSizeLong()).add_upsert_receivers() = std::move(proto);
  }
  return pieces.Take();
}

absl::StatusOr<SceneDelta> FromProto(const v1::SceneDelta& proto, const BlobSource& blobs) {
  SceneDelta delta;
  if (proto.has_base_revision()) delta.base_revision = proto.base_revision();
  delta.upsert_instances.reserve(proto.upsert_instances_size());
  for (int i = 0; i < proto.upsert_instances_size(); ++i) {
    auto instance = FromProto(proto.upsert_instances(i), blobs, ElementPath("upsert_instances", i));
    if (!instance.ok()) return instance.status();
    delta.upsert_instances.push_back(*std::move(instance));
  }
  for (int i = 0; i < proto.upsert_lights_size(); ++i) {
    auto light = FromProto(proto.upsert_lights(i), ElementPath("upsert_lights", i));
    if (!light.ok()) return light.status();
    delta.upsert_lights.push_back(*std::move(light));
  }
  for (int i = 0; i < proto.upsert_receivers_size(); ++i) {
    auto receiver = FromProto(proto.upsert_receivers(i), ElementPath("upsert_receivers", i));
    if (!receiver.ok()) return receiver.status();
    delta.upsert_receivers.push_back(*std::move(receiver));
  }
  delta.remove_instances.assign(proto.remove_instances().begin(), proto.remove_instances().end());
  delta.remove_lights.assign(proto.remove_lights().begin(), proto.remove_lights().end());
  delta.remove_receivers.assign(proto.remove_receivers().begin(), proto.remove_receivers().end());
  if (proto.has_receive_on_planar_surfaces()) {
    delta.receive_on_planar_surfaces = FromProto(proto.receive_on_planar_surfaces());
  }
  return delta;
}

SceneInfo InfoOf(const Scene& scene) {
  return {.id = scene.id(),
          .revision = scene.revision(),
          .content_hash = scene.content_hash(),
          .instance_count = scene.instances().size(),
          .light_count = scene.lights().size(),
          .receiver_count = scene.receivers().size()};
}

v1::SceneInfo ToProto(const SceneInfo& info) {
  v1::SceneInfo proto;
  proto.set_scene_id(info.id);
  proto.set_revision(info.revision);
  proto.set_content_hash(ToProto(info.content_hash));
  proto.set_instance_count(info.instance_count);
  proto.set_light_count(info.light_count);
  proto.set_receiver_count(info.receiver_count);
  return proto;
}

absl::StatusOr<SceneInfo> FromProto(const v1::SceneInfo& proto) {
  const auto hash = HashFromProto(proto.content_hash(), "content_hash");
  if (!hash.ok()) return hash.status();
  return SceneInfo{.id = proto.scene_id(),
                   .revision = proto.revision(),
                   .content_hash = *hash,
                   .instance_count = proto.instance_count(),
                   .light_count = proto.light_count(),
                   .receiver_count = proto.receiver_count()};
}

}  // namespace penumbra
