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
  proto.set_max_artifacts_per_scene(limits.max_artifacts_per_scene);
  proto.set_max_kept_bytes(limits.max_kept_bytes);
  proto.set_max_credit(limits.max_credit);
  proto.set_max_idempotency_keys(limits.max_idempotency_keys);
  proto.set_max_idempotency_key_bytes(limits.max_idempotency_key_bytes);
  proto.set_max_client_name_bytes(limits.max_client_name_bytes);
  proto.set_max_queued_replies(limits.max_queued_replies);
  proto.set_max_transport_message_bytes(limits.max_transport_message_bytes);
  proto.set_max_metadata_bytes(limits.max_metadata_bytes);
  proto.set_max_streams_per_connection(limits.max_streams_per_connection);
  proto.set_max_display_name_bytes(limits.max_display_name_bytes);
  proto.set_max_selected_ids(limits.max_selected_ids);
  proto.set_max_stall_seconds(limits.max_stall_seconds);
  proto.set_max_pending_commits(limits.max_pending_commits);
  proto.set_max_pending_commit_bytes(limits.max_pending_commit_bytes);
  proto.set_max_all_pending_commit_bytes(limits.max_all_pending_commit_bytes);
  proto.set_max_commit_delay_ms(limits.max_commit_delay_ms);
  proto.set_max_read_delay_ms(limits.max_read_delay_ms);
  proto.set_max_history_bytes(limits.max_history_bytes);
  proto.set_max_artifacts(limits.max_artifacts);
  return proto;
}

}  // namespace penumbra
