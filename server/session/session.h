// What one client's session is, apart from its connection: requests go in, messages come out.
//
//   auto session = Session::Create(services, caller, wake);
//   session->OnRequest(bytes);                        // as they arrive, one at a time
//   while (session->Next(…))                          // whenever there is room; after each `wake`
//
// It holds at most the unread replies (bounded: read no further request while has_room() is false),
// one scene and one artifact a subscription, however slowly the client reads.
#pragma once

#include <chrono>
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
#include "server/security/caller.h"
#include "server/session/scene_mirror.h"
#include "server/session/session_ledger.h"
#include "server/session/session_services.h"
#include "server/session/subscription_feed.h"

namespace penumbra {

class Session : public SceneWatcher,
                public StreamListener,
                public PresenceListener,
                public std::enable_shared_from_this<Session> {
 public:
  // `wake` is called, from any thread and without locks of the session's, when Next may have
  // something; `let_go` when the client is to be cut off, whatever is on its way to it.
  using LetGo = std::function<void(const absl::Status&)>;
  static std::shared_ptr<Session> Create(const SessionServices& services, const Caller& caller,
                                         std::function<void()> wake, LetGo let_go);
  ~Session() override;

  void OnRequest(const grpc::ByteBuffer& bytes);

  struct Output {
    std::optional<grpc::ByteBuffer> message;  // to be sent now
    std::optional<absl::Status> end;          // everything is sent, and the session is over
  };
  // Neither: there is nothing to send now.
  Output Next();
  // What Next gave last has been taken by the connection.
  void OnSent();
  // Lets the client go if the connection has taken nothing for max_stall_seconds.
  void EndIfStalled(std::chrono::steady_clock::time_point now);
  void TellOfCompute();  // whether its principal has some in hand, where that has changed

  // Whether another request may be read. None may once the session is ending.
  bool has_room() const;
  // Sends what replies there are, and then ends with `status`. The first call counts.
  void End(const absl::Status& status);
  // The connection is gone: lets go of everything.
  void Close();

  void OnScene(std::shared_ptr<const Scene> scene) override;
  void OnSceneDeleted(const absl::Status& reason) override;
  void OnStreamChanged() override { wake_(); }
  void OnPresenceChanged() override;

  SessionRecord& record() { return *record_; }  // for whoever carries its messages

 private:
  struct Reply {
    v1::SessionResponse response{};
    std::shared_ptr<const Scene> scene{};  // made by the commit that this answers
    Revision revision = 0;                 // that the client must have heard of before
    bool is_ready = true;                  // false: the commit is on its way to the disk
  };
  using FeedTable = std::map<uint64_t, std::unique_ptr<SubscriptionFeed>>;

  Session(const SessionServices& services, const Caller& caller, std::function<void()> wake,
          LetGo let_go);

  absl::Status OnHello(const v1::Hello& hello);
  absl::Status CheckHello(const v1::Hello& hello) const;
  void Enter(const v1::Hello& hello, const Scene& scene);
  void Greet(const v1::Hello& hello, Reply& welcome);
  void OnCommit(const v1::Commit& commit, const absl::Status& allowed);
  void Apply(const v1::Commit& commit, CommitCallback done);
  void AnswerCommit(Reply& reply, const absl::StatusOr<CommitOutcome>& outcome);
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
  absl::Status OnPresence(const v1::Presence& presence);
  void OnEditControl(const v1::EditControl& control);
  absl::Status Dispatch(const v1::SessionRequest& request);
  v1::SessionResponse MakeWelcome(const Scene& scene, uint32_t version) const;
  // With the lock held, as for the next three.
  void HurryReply(const Reply& reply);
  Output Choose();
  bool MirrorAllows(const Reply& reply);
  std::optional<grpc::ByteBuffer> NextNews(bool is_feed_due);
  grpc::ByteBuffer ComputeNews();
  bool is_ending() const;
  void Push(v1::SessionResponse response, std::shared_ptr<const Scene> scene = nullptr);
  void Release(std::unique_ptr<SubscriptionFeed> feed);
  SubscriptionFeed* DueFeed();

  const SessionServices services_;
  const Caller caller_;
  const std::function<void()> wake_;
  const LetGo let_go_;
  const std::shared_ptr<SessionRecord> record_;
  const std::string viewer_;  // the engine's name for who is behind this session

  // Set by the hello, before anybody else knows of the session; not changed after that.
  std::string scene_id_;
  std::string incarnation_;
  std::string client_name_;
  std::shared_ptr<PresenceRoom> room_;
  std::string participant_id_;  // empty: not seen by others

  mutable std::mutex mutex_;  // guards all below
  bool is_welcome_ = false;   // and may be told other things
  bool has_presence_news_ = false, told_presence_last_ = false, told_over_compute_ = false;
  absl::Status compute_;  // an error: its principal has none in hand now
  PresenceCursor told_presence_;
  std::optional<std::chrono::steady_clock::time_point> handed_over_at_;  // none: nothing under way
  bool mirrors_scene_ = false, closed_ = false;
  SceneMirror mirror_;
  // In the order of the requests, but first those that ask to wait.
  std::deque<std::shared_ptr<Reply>> replies_;
  // Of these, answers to a Subscribe, before which nothing of that subscription may be sent.
  size_t unsent_subscribe_results_ = 0;
  FeedTable feeds_;
  uint64_t last_fed_ = 0;  // id of the subscription that sent last; the next one is due first
  std::optional<absl::Status> end_;
};

}  // namespace penumbra
