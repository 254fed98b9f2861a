#include "tests/fuzz/targets/session_server.h"

#include <cstddef>
#include <vector>

#include "render/scene/blob.h"
#include "tests/fuzz/kit/require.h"
#include "tests/fuzz/targets/small_studio.h"

namespace penumbra::fuzzing {
namespace {

Caller Anybody(const ServerSecurity& security) {
  const grpc::CallbackServerContext context;
  return security.guard().Admit(context, "Session").value();
}

LocalEngineOptions FewThreads(const ServerLimits& limits) {
  LocalEngineOptions options;
  options.cpu_threads = 1;
  options.runner_threads = 1;
  options.delivery_threads = 1;
  options.scene_limits = limits.scene;
  return options;
}

void Upload(BlobStore& blobs, const ContentHash& hash, const std::vector<std::byte>& bytes) {
  const auto upload = blobs.Begin(hash, bytes.size());
  Require(upload.ok(), "there is room for the studio's blobs");
  const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  Require((*upload)->Append(text).ok() && (*upload)->Finish().ok(), "the studio's blobs are sound");
}

}  // namespace

SessionServer::SessionServer(const ServerLimits& limits)
    : limits_(limits), caller_(Anybody(*security_)), engine_(FewThreads(limits)) {
  for (const auto& mesh : {StudioBox(), StudioSquare()}) {
    Upload(blobs_, mesh->id(), EncodeBlob(mesh->geometry()));
  }
  Upload(blobs_, StudioMask()->id(), EncodeBlob(*StudioMask()));
}

void SessionServer::MakeScene() {
  Require(scenes_.Create("studio").ok(), "a scene's id is free once it is deleted");
  scenes_.Commit("studio", {.delta = StudioDelta()}, {}, [](const auto& outcome) {
    Require(outcome.ok(), "the studio is sound: " + outcome.status().ToString());
  });
  incarnation_ = scenes_.Watch("studio", {}).value().incarnation;
  room_ = presence_.RoomOf(incarnation_);
}

void SessionServer::DropScene() {
  Require(scenes_.Delete("studio").ok(), "a scene can be deleted");
  room_.reset();
}

std::shared_ptr<Session> SessionServer::Open() {
  return Session::Create(
      services_, caller_, [] {}, [](const absl::Status&) {});
}

std::string SessionServer::Editor() const {
  PresenceCursor told;
  v1::PresenceUpdate update;
  room_->ChangesSince(told, "", update);
  return update.editor_id();
}

void SessionServer::RequireNothingOpen() const {
  Require(artifacts_.subscription_count() == 0 && counters_.open_subscriptions == 0,
          "what a session followed goes with it");
}

}  // namespace penumbra::fuzzing
