// What a client says in a session, from its bytes to what the server makes of it: few bytes never
// become much memory, what is refused is refused by name, and what is taken means the same when it
// is said again.

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "penumbra/v1/session.pb.h"
#include "proto/convert/geometry_convert.h"
#include "proto/convert/scene_convert.h"
#include "proto/convert/spec_convert.h"
#include "render/technique/technique.h"
#include "server/limits.h"
#include "server/session/bounded_parse.h"
#include "server/session/delay_line.h"
#include "server/session/presence.h"
#include "tests/fuzz/kit/require.h"
#include "tests/fuzz/kit/target.h"
#include "tests/fuzz/targets/scene_rules.h"
#include "tests/fuzz/targets/session_request_seeds.h"
#include "tests/fuzz/targets/small_studio.h"

namespace penumbra::fuzzing {
namespace {

// So little that scripts come to it.
ServerLimits Limits() {
  ServerLimits limits{.scene = SmallLimits()};
  limits.max_message_bytes = 1u << 14;
  limits.always_allowed_parsed_bytes = 1u << 13;
  return limits;
}

std::span<const uint8_t> BytesOfText(const std::string& text) {
  return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
}

class SessionRequests final : public Target {
 public:
  std::span<const StepKind> kinds() const override { return kinds_; }
  void Run(const Script& script) override;
  std::vector<Seed> Seeds() override { return SessionRequestSeeds(); }

 private:
  void Receive(const std::string& bytes);
  void CheckParsed(const std::string& bytes, const v1::SessionRequest& request) const;
  absl::Status Dispatch(v1::SessionRequest& request);
  absl::Status OnHello(const v1::Hello& hello);
  absl::Status OnCommit(const v1::Commit& commit);
  absl::Status OnSpec(const v1::ArtifactSpec& proto);
  absl::Status OnSubscribeEach(const v1::SubscribeEach& request);
  absl::Status OnViewReport(const v1::ViewReport& report);
  absl::Status OnPresence(const v1::Presence& presence);
  absl::Status OnEditControl(v1::EditControl& control);
  void CheckRoom() const;
  std::string EditorNow() const;

  const ServerLimits limits_ = Limits();
  const StepKind kinds_[kSessionKinds] = {{"request", &v1::SessionRequest::default_instance()},
                                          {"bytes"}};
  DelayLine delay_{PresenceRoom::kInterval};
  // Of the script that runs.
  std::shared_ptr<const Scene> scene_;
  std::shared_ptr<PresenceRoom> room_;
  std::string me_, other_;
};

void SessionRequests::Run(const Script& script) {
  scene_ = Scene::Empty("studio")->Apply(StudioDelta(), limits_.scene).value();
  room_ = std::make_shared<PresenceRoom>(delay_);
  me_ = room_->Join({}, {});
  other_ = room_->Join({}, {});
  for (const Step& step : script) Receive(step.payload);
}

void SessionRequests::Receive(const std::string& bytes) {
  v1::SessionRequest request;
  const absl::Status parsed = ParseBounded(BytesOfText(bytes), limits_, request);
  if (!parsed.ok()) {
    Count(false);
    return RequireNamedRefusal(parsed);
  }
  CheckParsed(bytes, request);
  const absl::Status status = Dispatch(request);
  Count(status.ok());
  if (!status.ok()) RequireNamedRefusal(status);
  CheckRoom();
}

void SessionRequests::CheckParsed(const std::string& bytes,
                                  const v1::SessionRequest& request) const {
  const uint64_t most = std::max<uint64_t>(limits_.always_allowed_parsed_bytes,
                                           uint64_t{bytes.size()} * limits_.parsed_bytes_per_byte);
  // Besides: numbers of one byte that take four, in lists that have room for as many more.
  Require(request.SpaceUsedLong() <= most + 16 * bytes.size() + sizeof(v1::SessionRequest),
          "few bytes do not become much memory");
  v1::SessionRequest known = request;
  known.DiscardUnknownFields();
  const std::string again = request.SerializeAsString();
  Require(known.SerializeAsString() == again, "unknown fields are dropped");
  // In other bytes, which may be too few for what is in them, or too many.
  v1::SessionRequest reread;
  const absl::Status status = ParseBounded(BytesOfText(again), limits_, reread);
  Require(status.ok() || absl::IsResourceExhausted(status), "what is taken is taken again");
  Require(!status.ok() || reread.SerializeAsString() == again, "and says the same");
}

absl::Status SessionRequests::Dispatch(v1::SessionRequest& request) {
  switch (request.request_case()) {
    case v1::SessionRequest::kHello:
      return OnHello(request.hello());
    case v1::SessionRequest::kCommit:
      return OnCommit(request.commit());
    case v1::SessionRequest::kSubscribe:
      return OnSpec(request.subscribe().spec());
    case v1::SessionRequest::kSubscribeEach:
      return OnSubscribeEach(request.subscribe_each());
    case v1::SessionRequest::kViewReport:
      return OnViewReport(request.view_report());
    case v1::SessionRequest::kPresence:
      return OnPresence(request.presence());
    case v1::SessionRequest::kEditControl:
      return OnEditControl(*request.mutable_edit_control());
    default:  // numbers alone, and any will do
      return absl::OkStatus();
  }
}

absl::Status SessionRequests::OnHello(const v1::Hello& hello) {
  if (auto status = CheckId(hello.scene_id(), "hello.scene_id"); !status.ok()) return status;
  if (hello.has_resume()) {
    const auto hash = HashFromProto(hello.resume().content_hash(), "hello.resume.content_hash");
    if (!hash.ok()) return hash.status();
    Require(ToProto(*hash) == hello.resume().content_hash(), "a hash is its bytes");
  }
  return hello.has_presence() ? OnPresence(hello.presence()) : absl::OkStatus();
}

absl::Status SessionRequests::OnCommit(const v1::Commit& commit) {
  static const KnownBlobs blobs = StudioBlobs();
  if (auto status = room_->CheckMayEdit(me_); !status.ok()) {
    Require(EditorNow() != me_, "the one editor may edit");
    return status;
  }
  const auto delta = FromProto(commit.delta(), blobs);
  if (!delta.ok()) return delta.status();
  const auto after = scene_->Apply(*delta, limits_.scene);
  if (!after.ok()) return after.status();
  RequireRules(**after, limits_.scene);
  scene_ = *after;
  return absl::OkStatus();
}

absl::Status SessionRequests::OnSpec(const v1::ArtifactSpec& proto) {
  const auto spec = FromProto(proto);
  if (!spec.ok()) return spec.status();
  const auto target = TargetOf(proto);
  Require(target.ok() && *target == InfoOf(spec->params).target, "a spec is for a target");
  const v1::ArtifactSpec told = ToProto(*spec);
  const auto again = FromProto(told);
  Require(again.ok(), "a spec can be told: " + again.status().ToString());
  // As bytes: what is no number is not equal to itself.
  Require(ToProto(*again).SerializeAsString() == told.SerializeAsString(), "and stays the same");
  Require(SpecKey(*again) == SpecKey(*spec), "equal specs have one key");
  return TechniqueFor(spec->params).Check(*scene_, *spec);
}

// As a subscription for each; one will do here.
absl::Status SessionRequests::OnSubscribeEach(const v1::SubscribeEach& request) {
  const auto target = TargetOf(request.technique());
  if (!target.ok()) return target.status();
  v1::ArtifactSpec one = request.technique();
  one.set_light_id(request.light_ids().empty() ? "lamp" : request.light_ids(0));
  if (*target == SpecTarget::kReceiver) {
    one.set_receiver_id(request.receiver_ids().empty() ? "floor" : request.receiver_ids(0));
  }
  return OnSpec(one);
}

absl::Status SessionRequests::OnViewReport(const v1::ViewReport& report) {
  if (!report.has_camera()) return absl::OkStatus();
  const auto view = FromProto(report.camera());
  if (!view.ok()) return view.status();
  const auto again = FromProto(ToProto(*view));
  Require(again.ok() && again->camera == view->camera && again->aspect == view->aspect,
          "a view stays the same");
  for (const auto& [id, receiver] : scene_->receivers()) {
    const auto patch = scene_->ResolveReceiver(id);
    if (!patch.ok()) continue;
    const double share = ViewedShare(*view, patch->patch);
    Require(share >= 0 && share <= 1, "the part of a picture that something fills is one");
  }
  return absl::OkStatus();
}

absl::Status SessionRequests::OnPresence(const v1::Presence& presence) {
  if (auto status = CheckPresence(presence, limits_); !status.ok()) return status;
  room_->Report(me_, presence);
  // The other one is told just that.
  PresenceCursor told;
  v1::PresenceUpdate update;
  Require(room_->ChangesSince(told, other_, update) && update.participants_size() == 1,
          "who is here is told, but not of himself");
  Require(update.participants(0).presence().SerializeAsString() == presence.SerializeAsString(),
          "others are told what was said");
  return absl::OkStatus();
}

absl::Status SessionRequests::OnEditControl(v1::EditControl& control) {
  const auto id_of = [this](const std::string& name) {
    return name == kMe ? me_ : name == kOther ? other_ : name;
  };
  if (control.has_take()) control.mutable_take()->set_from_id(id_of(control.take().from_id()));
  if (control.has_hand_over()) {
    auto& hand_over = *control.mutable_hand_over();
    hand_over.set_participant_id(id_of(hand_over.participant_id()));
  }
  const std::string before = EditorNow();
  // Both take turns, so that there is somebody to take it from.
  const bool is_other = control.request_id() % 2 == 1;
  const std::string& who = is_other ? other_ : me_;
  const absl::Status status = room_->Control(who, control);
  const std::string after = EditorNow();
  Require(status.ok() || after == before, "what is refused changes nothing");
  Require(!status.ok() || !control.has_take() || after == who, "whoever takes it has it");
  Require(after == before || before == who || control.has_take(), "nobody gives away another's");
  return status;
}

std::string SessionRequests::EditorNow() const {
  PresenceCursor told;
  v1::PresenceUpdate update;
  room_->ChangesSince(told, "", update);
  return update.editor_id();
}

void SessionRequests::CheckRoom() const {
  PresenceCursor told;
  v1::PresenceUpdate update;
  Require(room_->ChangesSince(told, "", update) && update.is_everything(),
          "whoever comes is told everything");
  Require(update.participants_size() == 2 && update.left().empty(), "two are here");
  Require(update.ByteSizeLong() <= (1u << 20), "what is told fits into a message");
  const std::string& editor = update.editor_id();
  Require(editor.empty() || editor == me_ || editor == other_, "who edits is here");
  Require(editor.empty() || update.single_editor(), "one edits where only one may");
  for (const std::string& id : {me_, other_}) {
    Require(room_->CheckMayEdit(id).ok() == (!update.single_editor() || editor == id),
            "only the one editor may");
  }
}

}  // namespace

Target& TheTarget() {
  static SessionRequests target;
  return target;
}

}  // namespace penumbra::fuzzing
