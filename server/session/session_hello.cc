// How a session begins: from the start, or where an earlier one ended.

#include <algorithm>
#include <string>
#include <utility>

#include "penumbra/v1/session.pb.h"
#include "proto/convert/geometry_convert.h"
#include "proto/convert/scene_convert.h"
#include "proto/convert/spec_convert.h"
#include "render/scene/field_error.h"
#include "render/scene/scene.h"
#include "server/server_identity.h"
#include "server/session/session.h"

namespace penumbra {
namespace {

absl::Status Invalid(const char* reason, const char* field, const std::string& text) {
  return FieldError(absl::StatusCode::kInvalidArgument, reason, field, text);
}

absl::Status MayOpen(const Caller& caller, const std::string& scene_id) {
  absl::Status status = CheckId(scene_id, "scene_id");
  if (status.ok()) status = caller.Authorize("Session.hello", scene_id);
  return status.ok() ? status : WithFieldPrefix(status, "hello.");
}

}  // namespace

absl::Status Session::OnHello(const v1::Hello& hello) {
  if (!scene_id_.empty()) {
    return FieldError(absl::StatusCode::kFailedPrecondition, "HELLO_REPEATED", "hello",
                      "found a second one, need one in a session");
  }
  if (auto status = CheckHello(hello); !status.ok()) return status;
  const auto& versions = hello.protocol_versions();
  absl::Status refused = MayOpen(caller_, hello.scene_id());
  if (std::find(versions.begin(), versions.end(), kProtocolVersion) == versions.end()) {
    refused = FieldError(
        absl::StatusCode::kFailedPrecondition, "VERSION", "hello.protocol_versions",
        "found no version that this server speaks, need " + std::to_string(kProtocolVersion));
  }
  if (!refused.ok()) {
    End(refused);
    return absl::OkStatus();
  }
  const auto watched = services_.scenes.Watch(hello.scene_id(), weak_from_this());
  if (!watched.ok()) {
    End(WithFieldPrefix(watched.status(), "hello."));
    return absl::OkStatus();
  }
  scene_id_ = hello.scene_id();
  incarnation_ = watched->incarnation;
  client_name_ = hello.client_name();
  record_->Greet(scene_id_, client_name_);
  Enter(hello, *watched->scene);
  return absl::OkStatus();
}

void Session::Enter(const v1::Hello& hello, const Scene& scene) {
  room_ = services_.presence.RoomOf(incarnation_);
  const auto welcome = std::make_shared<Reply>(
      Reply{.response = MakeWelcome(scene, kProtocolVersion), .is_ready = false});
  {
    std::lock_guard lock(mutex_);
    if (closed_) return;
    if (hello.has_presence()) {
      participant_id_ = room_->Join(weak_from_this(), hello.presence());
      has_presence_news_ = true;
    }
    welcome->response.mutable_welcome()->set_participant_id(participant_id_);
    replies_.push_back(welcome);
  }
  FairLane* const lane = services_.scenes.history_lane();
  const bool is_behind = hello.has_resume() && hello.resume().revision() != scene.revision();
  if (lane && is_behind) {
    lane->Post(caller_.identity().name,
               [self = shared_from_this(), hello, welcome] { self->Greet(hello, *welcome); });
  } else {
    Greet(hello, *welcome);
  }
}

absl::Status Session::CheckHello(const v1::Hello& hello) const {
  if (hello.client_name().size() > services_.limits.max_client_name_bytes) {
    return Invalid("LENGTH", "hello.client_name",
                   "found " + std::to_string(hello.client_name().size()) + " bytes, need at most " +
                       std::to_string(services_.limits.max_client_name_bytes));
  }
  if (hello.has_resume()) {
    if (!hello.mirror_scene()) {
      return Invalid("MISSING_FIELD", "hello.mirror_scene", "found false, need it for `resume`");
    }
    const auto hash = HashFromProto(hello.resume().content_hash(), "hello.resume.content_hash");
    if (!hash.ok()) return hash.status();
  }
  if (!hello.has_presence()) return absl::OkStatus();
  return WithFieldPrefix(CheckPresence(hello.presence(), services_.limits), "hello.");
}

// May wait for the disk.
void Session::Greet(const v1::Hello& hello, Reply& welcome) {
  {
    // The client may have gone before its turn came.
    std::lock_guard lock(mutex_);
    if (closed_) return;
  }
  std::shared_ptr<const Scene> from;
  if (hello.has_resume()) {
    const auto at = services_.scenes.SceneAt(scene_id_, hello.resume().incarnation(),
                                             hello.resume().revision());
    if (at.ok() && ToProto((*at)->content_hash()) == hello.resume().content_hash()) from = *at;
  }
  {
    std::lock_guard lock(mutex_);
    if (from) mirror_.StartFrom(from);
    welcome.response.mutable_welcome()->set_is_resumed(from != nullptr);
    welcome.is_ready = true;
    mirrors_scene_ = hello.mirror_scene();
  }
  // The newest: a commit may have come between.
  const auto newest = services_.scenes.Snapshot(scene_id_);
  if (newest.ok()) OnScene(*newest);
  wake_();
}

v1::SessionResponse Session::MakeWelcome(const Scene& scene, uint32_t version) const {
  v1::SessionResponse response;
  v1::Welcome& welcome = *response.mutable_welcome();
  welcome.set_protocol_version(version);
  welcome.set_server_name(kServerName);
  *welcome.mutable_limits() = ToProto(services_.limits);
  for (auto& technique : AllTechniqueInfos()) *welcome.add_techniques() = std::move(technique);
  for (const v1::Codec codec :
       {v1::CODEC_RAW, v1::CODEC_ZSTD, v1::CODEC_ALL_VISIBLE, v1::CODEC_NONE_VISIBLE}) {
    welcome.add_codecs(codec);
  }
  *welcome.mutable_scene() = ToProto(InfoOf(scene));
  welcome.set_incarnation(incarnation_);
  return response;
}

}  // namespace penumbra
