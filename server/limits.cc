#include "server/limits.h"

#include "proto/convert/scene_convert.h"

namespace penumbra {

v1::Limits ToProto(const ServerLimits& limits) {
  v1::Limits proto;
  WriteSceneLimits(limits.scene, proto);
  proto.set_max_scenes(limits.max_scenes);
  proto.set_max_message_bytes(limits.max_message_bytes);
  proto.set_max_blob_bytes(limits.max_blob_bytes);
  proto.set_max_blob_store_bytes(limits.max_blob_store_bytes);
  proto.set_max_subscriptions_per_session(limits.max_subscriptions_per_session);
  proto.set_max_sessions(limits.max_sessions);
  proto.set_max_hashes_per_request(limits.max_hashes_per_request);
  return proto;
}

}  // namespace penumbra
