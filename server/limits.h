// Everything that the server bounds, each with its reason. GetServerInfo and the session's welcome
// report them.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

#include "penumbra/v1/server_info.pb.h"
#include "render/scene/scene_limits.h"
#include "server/archive_limits.h"

namespace penumbra {

struct ServerLimits {
  // Of each scene; the reasons stand there.
  SceneLimits scene{};

  // A scene of a few objects takes kilobytes, a full one 100 MB besides its blobs.
  uint32_t max_scenes = 256;
  // Different ones (technique, parameters, light, receiver) that are followed on one scene, and on
  // all of them. Each has at most one computation waiting, so these bound the queue.
  uint32_t max_artifacts_per_scene = 1'024;
  uint32_t max_artifacts = 16'384;
  // What techniques keep of all artifacts together, to answer edits faster. Over it they keep less.
  uint64_t max_kept_bytes = uint64_t{256} << 20;

  // Either way. A delta of 8,000 instances fits; one tile of counts and radiance takes 64 KB at
  // most.
  uint32_t max_message_bytes = 1u << 20;
  // gRPC ends the call at its own limit, so this is higher: up to here the session lives on and
  // says which limit was passed.
  uint32_t max_transport_message_bytes = 4u << 20;
  // What a message may take in memory once it is parsed, for each of its bytes. Protobuf spends 150
  // bytes and more on an empty sub-message that takes 2; the worst of honest messages, the removal
  // of a full scene by the shortest ids, takes 13.
  uint32_t parsed_bytes_per_byte = 20;
  // However short the message is: 16,000 sub-messages.
  uint32_t always_allowed_parsed_bytes = 2u << 20;

  // The largest mesh that the scene's limits allow, with normals and uvs, takes 704 MB.
  uint64_t max_blob_bytes = uint64_t{1} << 30;
  // All blobs together, uploads in progress included.
  uint64_t max_blob_store_bytes = uint64_t{4} << 30;
  // 32 bytes each: half a message. As many blobs come in one upload.
  uint32_t max_hashes_per_request = 16'384;
  // A blob that was asked for or uploaded is kept this long without a scene that uses it.
  std::chrono::seconds unused_blob_lifetime{60};
  // An upload that sends nothing for so long is dropped, and a download that does not take one
  // message in.
  std::chrono::seconds transfer_idle_timeout{30};

  // Each keeps one message of 1 MiB at most in flight.
  uint32_t max_sessions = 1'024;
  // A texture of every polygon of a room in a few lights; as many as the engine keeps of a scene.
  uint32_t max_subscriptions_per_session = 1'024;
  uint32_t max_credit = 1'000'000;
  // Replies that a client has not read; past that its requests wait in the transport.
  size_t max_queued_replies = 64;
  // For answering repeated commits, per scene; 100 bytes each.
  size_t max_idempotency_keys = 1'024;
  uint32_t max_idempotency_key_bytes = 64;
  uint32_t max_client_name_bytes = 256;
  // What others are told of a user: names for people, and what is selected.
  uint32_t max_display_name_bytes = 256;
  uint32_t max_selected_ids = 64;
  // A client that has not taken a message for so long is let go; it can resume.
  uint32_t max_stall_seconds = 30;
  // Of one scene, on their way to the disk: in number, and 32 of the largest messages.
  size_t max_pending_commits = 4'096;
  uint64_t max_pending_commit_bytes = 32u << 20;
  // Of all scenes. A principal has at most half of what the others leave of it: whoever comes next
  // finds room.
  uint64_t max_all_pending_commit_bytes = 128u << 20;
  // While the oldest commit of a scene, or the scene that has waited longest for a writer, has
  // waited longer than this for the disk, others are refused at once: they would wait even longer.
  uint32_t max_commit_delay_ms = 250;
  // While requests wait longer than this until they are read, commits are refused, and some of them
  // from a tenth of it on: whoever is refused is to hear of it soon.
  uint32_t max_read_delay_ms = 10;
  // What is kept of a scene's past besides its newest snapshot.
  uint64_t max_history_bytes = uint64_t{256} << 20;

  ArchiveLimits archives{};

  // Half a TLS handshake or HTTP/2 preface, then silence.
  std::chrono::milliseconds handshake_timeout{3'000};
  // A peer that vanished is found within their sum.
  std::chrono::milliseconds keepalive_interval{15'000};
  std::chrono::milliseconds keepalive_timeout{10'000};
  // Clients may ask as often whether we are there; who asks more often is let go.
  std::chrono::milliseconds least_ping_interval{5'000};
  // A connection without a call; a client's library opens it anew when it needs it.
  std::chrono::milliseconds connection_idle_timeout{120'000};
  // Request headers; ours take 300 bytes.
  uint32_t max_metadata_bytes = 16u << 10;
  uint32_t max_streams_per_connection = 256;
};

v1::Limits ToProto(const ServerLimits& limits);

}  // namespace penumbra
