// What one client's session is, apart from its connection: requests go in, messages come out.
//
//   auto session = Session::Create(services, caller, wake);
//   session->OnRequest(bytes);                        // as they arrive, one at a time
//   while (session->Next(…))                          // whenever there is room; after each `wake`
//
// It holds at most the unread replies (bounded: read no further request while has_room() is false),
// one scene and one artifact a subscription, however slowly the client reads.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "grpcpp/support/byte_buffer.h"
#include "penumbra/v1/session.pb.h"
#include "server/counters.h"
#include "server/limits.h"
#include "server/scene_store/blob_store.h"
#include "server/scene_store/scene_store.h"
#include "server/security/blob_access.h"
#include "server/security/caller.h"
#include "server/session/artifact_stream.h"
#include "server/session/scene_mirror.h"
#include "server/session/subscription_feed.h"

namespace penumbra {

// What sessions work with. All of it outlives them.
struct SessionServices {
  SceneStore& scenes;
  BlobStore& blobs;
  BlobAccess& blob_access;
  StreamTable& streams;
  const ServerLimits& limits;
  ServerCounters& counters;
};

class Session : public SceneWatcher,
                public StreamListener,
                public std::enable_shared_from_this<Session> {
 public:
  // `wake` is called, from any thread and without locks of the session's, when Next may have
  // something.
  static std::shared_ptr<Session> Create(const SessionServices& services, const Caller& caller,
                                         std::function<void()> wake);
  ~Session() override;

  void OnRequest(const grpc::ByteBuffer& bytes);

  struct Output {
    std::optional<grpc::ByteBuffer> message;  // to be sent now
    std::optional<absl::Status> end;          // everything is sent, and the session is over
  };
  // Neither: there is nothing to send now.
  Output Next();

  // Whether another request may be read. None may once the session is ending.
  bool has_room() const;
  // Sends what replies there are, and then ends with `status`. The first call counts.
  void End(const absl::Status& status);
  // The connection is gone: lets go of everything.
  void Close();

  void OnScene(std::shared_ptr<const Scene> scene) override;
  void OnSceneDeleted(const absl::Status& reason) override;
  void OnStreamChanged() override { wake_(); }

 private:
  struct Reply {
    v1::SessionResponse response{};
    std::shared_ptr<const Scene> scene{};  // made by the commit that this answers
  };
  using FeedTable = std::map<uint64_t, std::unique_ptr<SubscriptionFeed>>;

  Session(const SessionServices& services, const Caller& caller, std::function<void()> wake);

  absl::Status OnHello(const v1::Hello& hello);
  void OnCommit(const v1::Commit& commit, const absl::Status& allowed);
  absl::StatusOr<CommitOutcome> Apply(const v1::Commit& commit);
  void OnSubscribe(const v1::Subscribe& subscribe);
  absl::StatusOr<std::unique_ptr<SubscriptionFeed>> MakeFeed(const v1::Subscribe& subscribe);
  absl::StatusOr<std::unique_ptr<SubscriptionFeed>> Follow(uint64_t id, const ArtifactSpec& spec,
                                                           uint32_t credit);
  void OnSubscribeEach(const v1::SubscribeEach& request);
  absl::Status CheckRoom(uint64_t first_id, uint64_t count) const;
  absl::StatusOr<std::vector<std::unique_ptr<SubscriptionFeed>>> MakeFeeds(
      const v1::SubscribeEach& request, v1::SubscribeEachResult& result);
  absl::Status OnUnsubscribe(const v1::Unsubscribe& unsubscribe);
  absl::Status OnCredit(const v1::Credit& credit);
  absl::Status OnAcknowledgement(const v1::Acknowledgement& acknowledgement);
  absl::Status OnViewReport(const v1::ViewReport& report);
  absl::Status Dispatch(const v1::SessionRequest& request);
  v1::SessionResponse MakeWelcome(const Scene& scene, uint32_t version) const;

  bool is_ending() const;
  void Push(v1::SessionResponse response, std::shared_ptr<const Scene> scene = nullptr);
  void Release(std::unique_ptr<SubscriptionFeed> feed);
  SubscriptionFeed* DueFeed();

  const SessionServices services_;
  const Caller caller_;
  const std::function<void()> wake_;
  const std::string viewer_;  // the engine's name for who is behind this session

  // Set by the hello, then read only by OnRequest's thread.
  std::string scene_id_;
  uint64_t incarnation_ = 0;

  mutable std::mutex mutex_;  // guards all below
  bool mirrors_scene_ = false;
  SceneMirror mirror_;
  std::deque<Reply> replies_;
  FeedTable feeds_;
  uint64_t last_fed_ = 0;  // id of the subscription that sent last; the next one is due first
  std::optional<absl::Status> end_;
  bool closed_ = false;
};

}  // namespace penumbra
