// What a SceneSession keeps of its connections, its subscriptions and what it waits for.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "client/session/remote_subscriber.h"
#include "client/session/session_presence.h"
#include "penumbra/v1/service.grpc.pb.h"
#include "render/engine/engine.h"

namespace penumbra {

// One connection's share of a session.
struct SessionLink {
  uint64_t number = 0;  // counts up
  grpc::ClientContext context{};
  std::unique_ptr<grpc::ClientReaderWriter<v1::SessionRequest, v1::SessionResponse>> stream{};
  // Who has introduced themselves on it; null: nobody. What else is said of them needs the welcome.
  std::shared_ptr<SessionPresence> presence{};
  std::string participant_id{};  // the server's name for them
};

// Whoever is to be seen by others.
struct SessionEntry {
  v1::Presence presence;
  PresenceCallback callback;
};

// A subscription, which goes on on the next link.
struct FollowedSubscription {
  std::shared_ptr<RemoteSubscriber> subscriber;
  ArtifactSpec spec;
};

// What a caller waits for.
struct SessionAnswer {
  bool is_here = false;
  v1::SessionRequest request;  // to be sent again on another link
  uint64_t link = 0;           // that it was last sent on; guarded by write_mutex_
  absl::Status status;
  Revision revision = 0;
  SceneDelta delta;  // a commit's, for the mirror
  // Of a SubscribeEach: what the subscriptions are made from, and those made.
  TechniqueParams params;
  std::optional<PointReceiver> points;
  RemoteEngine::EachCallback each;
  double asked_ms = 0.0;
  std::vector<std::pair<ArtifactSpec, std::shared_ptr<RemoteSubscriber>>> made;
};

}  // namespace penumbra
