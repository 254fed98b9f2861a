// A client that holds what it is told in its session against what it has said: all is answered, in
// the order of saying it, by what the scene has become, and nothing else is.
//
//   SessionClient client(server, history, count);
//   client.Say(bytes);
//   client.Read();      // whatever there is; a slow client does so now and then
//   client.Leave();
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "google/rpc/status.pb.h"
#include "penumbra/v1/session.pb.h"
#include "tests/fuzz/targets/session_server.h"

namespace penumbra::fuzzing {

// What has become of a script's scene, whoever changed it.
struct SceneHistory {
  std::vector<ContentHash> hashes;          // by revision
  std::map<std::string, Revision> answers;  // by idempotency key: what the first commit made
};

class SessionClient {
 public:
  using CountAnswer = std::function<void(bool is_accepted)>;

  // Both outlive it.
  SessionClient(SessionServer& server, SceneHistory& history, CountAnswer count);

  // Of a client that has read too little the server reads nothing: then this reads first.
  void Say(const std::string& bytes);
  void Read();
  // Reads how its session ends after the scene was deleted. All before has been read.
  void ReadOfDeletion();
  // Closes the session, wherever it stands.
  void Leave();

  // Empty: it has not told who it is, or not been welcomed.
  const std::string& participant_id() const { return participant_id_; }

 private:
  // A request, and what it did.
  struct Said {
    v1::SessionRequest request{};
    absl::Status parsed{};
    Revision revision = 0;  // after it
    bool has_grown = false, has_other_editor = false;
  };
  struct Followed {
    uint64_t credit = 0;
    uint64_t sequence = 0;  // of the last update that is whole
    uint64_t skipped = 0;
    bool in_update = false;
  };

  void NoteScene(const Scene& before, const std::shared_ptr<const Scene>& after, Said& said);
  void NoteEditor(const std::string& before, Said& said) const;
  bool NeedsNoAnswer(const Said& said) const;
  void Settle();
  Said TakeAnswered();
  absl::Status Refused(const google::rpc::Status& error);
  void OnEnd(const absl::Status& end);
  // Whether it answers something.
  bool Hear(const v1::SessionResponse& response);
  void HearNews(const v1::SessionResponse& response);
  void OnWelcome(const v1::Welcome& welcome);
  void OnSessionError(const v1::SessionError& error);
  void OnCommitResult(const v1::CommitResult& result);
  void OnSubscribeResult(const v1::SubscribeResult& result);
  void OnSubscribeEachResult(const v1::SubscribeEachResult& result);
  void OnEditControlResult(const v1::EditControlResult& result);
  void OnSubscriptionEnded(const v1::SubscriptionEnded& ended);
  void OnSceneUpdate(const v1::SceneUpdate& update);
  void OnArtifactUpdate(const v1::ArtifactUpdate& update);
  void OnUpdatesSkipped(const v1::UpdatesSkipped& skipped);
  void OnPresenceUpdate(const v1::PresenceUpdate& update);
  void Follow(uint64_t id, uint32_t credit);

  SessionServer& server_;
  SceneHistory& history_;
  const CountAnswer count_;
  const std::shared_ptr<Session> session_;
  std::deque<Said> said_;  // and not known to be done
  // As far as it has read.
  std::map<uint64_t, Followed> followed_;
  bool is_welcome_ = false, has_presence_ = false, mirrors_ = false;
  bool is_told_of_others_ = false, is_scene_gone_ = false, is_over_ = false;
  std::string participant_id_;
  Revision told_ = 0;  // that its mirror is at; 0: it has none
  bool is_continued_ = false;
};

}  // namespace penumbra::fuzzing
