// One session: commits to a scene, subscriptions to its artifacts, a mirror of its content. Its
// stream may break; it then goes on with another one.
//
//   auto session = SceneSession::Open(connection, "studio");
//   auto revision = (*session)->Commit(delta);
#pragma once

#include <atomic>
#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/session/mirrored_scene.h"
#include "client/session/presence.h"
#include "client/session/reading_turns.h"
#include "client/session/remote_subscriber.h"
#include "client/session/session_parts.h"
#include "client/session/session_presence.h"
#include "penumbra/v1/service.grpc.pb.h"
#include "render/engine/engine.h"

namespace penumbra {

class ServerConnection;

class SceneSession : public std::enable_shared_from_this<SceneSession> {
 public:
  using Entry = SessionEntry;
  // Errors  kNotFound: no such scene; kFailedPrecondition VERSION; kUnavailable
  static absl::StatusOr<std::shared_ptr<SceneSession>> Open(
      ServerConnection& connection, const std::string& scene_id,
      const std::optional<Entry>& entry = std::nullopt);
  ~SceneSession();

  absl::StatusOr<Revision> Commit(const SceneDelta& delta);
  absl::StatusOr<std::shared_ptr<const Scene>> Snapshot();
  absl::StatusOr<std::unique_ptr<Subscription>> Subscribe(const ArtifactSpec& spec,
                                                          RemoteEngine::MeasuredCallback callback);
  // Waits for no answer: there is none to a view that CheckView finds nothing wrong with.
  absl::Status ReportView(const std::optional<View>& view);
  absl::StatusOr<std::vector<EachSubscription>> SubscribeEach(const EachRequest& request,
                                                              RemoteEngine::EachCallback callback);
  // Lets the user be seen, on another connection where there is one already.
  // Errors  kAlreadyExists ALREADY_PRESENT; what has ended the session
  absl::Status Enter(const Entry& entry);
  std::shared_ptr<SessionPresence> presence() const;  // null: the user is not seen
  absl::Status ControlEditing(const v1::EditControl& control);
  // The end of `presence`, from its owner: others see it gone, and the session goes on without.
  void Leave(const std::shared_ptr<SessionPresence>& presence);
  // The end of a subscription, from its owner.
  void Unsubscribe(RemoteSubscriber& subscriber);
  bool has_ended() const { return has_ended_; }
  // Cancels the stream: what is under way ends with `reason`. Does not wait.
  void End(const absl::Status& reason);
  // Waits for the session's threads. After this it makes no use of the connection.
  void Join();

 private:
  using Link = SessionLink;
  using Followed = FollowedSubscription;
  using Answer = SessionAnswer;
  using Answers = std::map<uint64_t, std::shared_ptr<Answer>>;

  // Updates under way at a time: enough that none waits for a round trip, few enough that a slow
  // callback soon makes the server skip.
  static constexpr uint32_t kInitialCredit = 4;

  SceneSession(ServerConnection& connection, const std::string& scene_id,
               const std::optional<Entry>& entry);

  absl::Status Greet();
  absl::StatusOr<Revision> TryCommit(const SceneDelta& delta);
  absl::StatusOr<Revision> CommitOnce(const SceneDelta& delta, v1::SessionRequest& request);
  std::shared_ptr<SessionPresence> MakePresence(const Entry& entry);
  absl::Status Named(const absl::Status& error) const;  // people by their names
  absl::Status Upload(const SceneDelta& delta, const Scene& known);
  // False: it is not on its way. On one link only, if any.
  bool Send(const v1::SessionRequest& request, bool more_follows = false,
            std::optional<uint64_t> link = std::nullopt);
  void SendOnce(Answer& answer);  // on a link, however many ask
  void SendConsumed(uint64_t subscription_id, const Consumed& consumed);
  absl::Status Await(Answers& answers, uint64_t id, const std::shared_ptr<Answer>& answer);

  std::shared_ptr<Link> OpenLink();
  bool MayResume(const absl::Status& reason) const;
  bool IsOutdated(const Link& link) const;
  bool Reconnect(const absl::Status& lost);
  bool BeginReconnecting();
  void Begin(Link& link);
  absl::Status Resume(const std::shared_ptr<Link>& link);
  bool ReadWelcome(const std::shared_ptr<Link>& link);
  void SendAgain(const std::shared_ptr<Link>& link);
  void ResumePresence(Link& link);
  bool WaitToTryAgain(double seconds);
  void Tell(ConnectionEvent::Kind kind, const absl::Status& reason, int attempts,
            bool missed_nothing = false) const;

  bool ReadOne();
  void Dispatch();
  void Hear(Revision revision);
  std::optional<double> HeardMs(Revision revision) const;
  void Receive(v1::CommitResult& result);
  void Receive(const v1::SubscribeResult& result);
  void Receive(const v1::SubscribeEachResult& result);
  void Receive(const v1::SubscriptionEnded& ended);
  void Receive(const v1::ArtifactUpdate& update);
  void Receive(const v1::SessionError& error);
  void Receive(const v1::EditControlResult& result);
  void Receive(const v1::PresenceUpdate& update);
  void MakeSubscribers(const v1::SubscribeEachResult& result, Answer& answer);
  void DropEach(uint64_t first, uint64_t count);
  void EndAll(const absl::Status& ended);
  void PostDelivery(std::shared_ptr<RemoteSubscriber> subscriber);
  std::shared_ptr<RemoteSubscriber> FindSubscriber(uint64_t id);

  ServerConnection& connection_;
  const std::string address_;
  const std::string scene_id_;
  MirroredScene mirror_;

  const std::string key_prefix_;         // of idempotency keys
  v1::SessionResponse response_;         // the reader's; kept for its memory
  std::map<Revision, double> heard_ms_;  // the reader's: when revisions were heard of
  std::string incarnation_;              // the reader's: which scene of this id it is
  std::mutex write_mutex_;               // one writes at a time; guards write_link_
  std::shared_ptr<Link> write_link_;

  std::atomic<bool> has_ended_{false};
  mutable std::mutex mutex_;  // guards the rest but the turns
  std::condition_variable changed_;
  std::shared_ptr<Link> link_;  // the reader's; what End cancels
  bool is_welcome_ = false;
  bool is_connected_ = true;
  std::optional<View> view_;  // reported last
  absl::Status end_reason_;   // why it has ended, or is being ended
  uint64_t next_id_ = 1;
  Answers commits_;
  Answers subscribes_;
  Answers controls_;
  std::shared_ptr<SessionPresence> presence_;
  std::map<uint64_t, Followed> subscribers_;
  ReadingTurns turns_;
};

}  // namespace penumbra
