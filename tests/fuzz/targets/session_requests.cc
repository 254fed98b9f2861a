// What clients say in their sessions, from its bytes to what they are told: two of them in a scene,
// each of which holds what it hears against what it said (session_client.h).

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "penumbra/v1/session.pb.h"
#include "proto/convert/geometry_convert.h"
#include "server/limits.h"
#include "tests/fuzz/kit/require.h"
#include "tests/fuzz/kit/target.h"
#include "tests/fuzz/targets/session_client.h"
#include "tests/fuzz/targets/session_request_seeds.h"
#include "tests/fuzz/targets/session_server.h"
#include "tests/fuzz/targets/small_studio.h"

namespace penumbra::fuzzing {
namespace {

// So little that scripts come to it.
ServerLimits Limits() {
  ServerLimits limits{.scene = SmallLimits()};
  limits.max_message_bytes = 1u << 14;
  limits.always_allowed_parsed_bytes = 1u << 13;
  limits.max_subscriptions_per_session = 32;  // each of the studio's lights on each receiver
  limits.max_credit = 1'000;
  limits.max_queued_replies = 4;
  // How busy the machine is does not count.
  limits.max_read_delay_ms = 0;
  return limits;
}

// Never destroyed: it goes with the process, and so do its threads.
SessionServer& TheServer() {
  static SessionServer& server = *new SessionServer(Limits());
  return server;
}

std::string SoundHello(const std::string& display_name) {
  v1::SessionRequest request;
  v1::Hello& hello = *request.mutable_hello();
  hello.add_protocol_versions(1);
  hello.set_scene_id("studio");
  hello.set_mirror_scene(true);
  hello.mutable_presence()->set_display_name(display_name);
  return request.SerializeAsString();
}

// Both change the scene and who edits it: whose turn it is says the request's number.
bool IsOfOther(const v1::SessionRequest& request) {
  return (request.has_commit() && request.commit().commit_id() % 2 == 1) ||
         (request.has_edit_control() && request.edit_control().request_id() % 2 == 1);
}

class SessionRequests final : public Target {
 public:
  std::span<const StepKind> kinds() const override { return kinds_; }
  void Run(const Script& script) override;
  std::vector<Seed> Seeds() override { return SessionRequestSeeds(); }

 private:
  void Open(const Script& script);
  void Take(const Step& step);
  void Close();
  std::string WithNames(const std::string& payload) const;
  std::string IdOf(const std::string& name) const;
  void CheckRoom() const;

  const StepKind kinds_[kSessionKinds] = {{"request", &v1::SessionRequest::default_instance()},
                                          {"bytes"}};
  // Of the script that runs.
  SceneHistory history_;
  std::unique_ptr<SessionClient> me_, other_;
};

void SessionRequests::Run(const Script& script) {
  Open(script);
  for (const Step& step : script) Take(step);
  Close();
}

void SessionRequests::Open(const Script& script) {
  TheServer().MakeScene();
  history_ = {
      .hashes = {Scene::Empty("studio")->content_hash(), TheServer().Newest()->content_hash()},
      .answers = {}};
  const auto count = [this](bool is_accepted) { Count(is_accepted); };
  me_ = std::make_unique<SessionClient>(TheServer(), history_, count);
  other_ = std::make_unique<SessionClient>(TheServer(), history_, count);
  other_->Say(SoundHello("Bob"));
  other_->Read();
  v1::SessionRequest first;
  const bool greets =
      !script.empty() && first.ParseFromString(script.front().payload) && first.has_hello();
  if (greets) return;
  me_->Say(SoundHello("Ada"));
  me_->Read();
}

void SessionRequests::Take(const Step& step) {
  const bool is_message = step.kind % kSessionKinds == kRequest;
  const std::string bytes = is_message ? WithNames(step.payload) : step.payload;
  v1::SessionRequest request;
  const bool is_of_other = request.ParseFromString(bytes) && IsOfOther(request);
  SessionClient& client = is_of_other ? *other_ : *me_;
  client.Say(bytes);
  // Clients are slow: whether they read now is drawn from what is there.
  const bool reads = bytes.size() % 2 == 0 || request.has_hello();
  if (reads) me_->Read();
  if (reads) other_->Read();
  CheckRoom();
}

void SessionRequests::Close() {
  me_->Read();
  other_->Read();
  TheServer().DropScene();
  me_->ReadOfDeletion();
  other_->ReadOfDeletion();
  me_->Leave();
  other_->Leave();
  TheServer().RequireNothingOpen();
  me_.reset();
  other_.reset();
}

// What a script can only call by a name.
std::string SessionRequests::WithNames(const std::string& payload) const {
  v1::SessionRequest request;
  if (!request.ParseFromString(payload)) return payload;
  if (request.has_hello() && request.hello().has_resume()) {
    v1::ResumePoint& resume = *request.mutable_hello()->mutable_resume();
    if (resume.incarnation() == kIncarnation) resume.set_incarnation(TheServer().incarnation());
    if (resume.content_hash() == kContentHash) {
      resume.set_content_hash(ToProto(TheServer().Newest()->content_hash()));
    }
  } else if (request.has_edit_control()) {
    v1::EditControl& control = *request.mutable_edit_control();
    if (control.has_take()) control.mutable_take()->set_from_id(IdOf(control.take().from_id()));
    if (control.has_hand_over()) {
      auto& hand_over = *control.mutable_hand_over();
      hand_over.set_participant_id(IdOf(hand_over.participant_id()));
    }
  } else {
    return payload;
  }
  return request.SerializeAsString();
}

std::string SessionRequests::IdOf(const std::string& name) const {
  return name == kMe ? me_->participant_id() : name == kOther ? other_->participant_id() : name;
}

void SessionRequests::CheckRoom() const {
  const PresenceRoom& room = TheServer().room();
  PresenceCursor told;
  v1::PresenceUpdate update;
  Require(room.ChangesSince(told, "", update) && update.is_everything(),
          "whoever comes is told everything");
  const int seen = me_->participant_id().empty() ? 1 : 2;
  Require(update.participants_size() == seen && update.left().empty(), "all who are seen are here");
  const std::string& editor = update.editor_id();
  Require(editor.empty() || editor == me_->participant_id() || editor == other_->participant_id(),
          "who edits is here");
  Require(editor.empty() || update.single_editor(), "one edits where only one may");
  for (const SessionClient* client : {me_.get(), other_.get()}) {
    const std::string& id = client->participant_id();
    const bool is_editor = !id.empty() && editor == id;
    Require(room.CheckMayEdit(id).ok() == (!update.single_editor() || is_editor),
            "only the one editor may");
  }
}

}  // namespace

Target& TheTarget() {
  static SessionRequests target;
  return target;
}

}  // namespace penumbra::fuzzing
