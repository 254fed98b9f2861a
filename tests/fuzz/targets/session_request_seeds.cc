#include "tests/fuzz/targets/session_request_seeds.h"

#include <string>

#include "penumbra/v1/session.pb.h"
#include "proto/convert/geometry_convert.h"
#include "proto/convert/scene_convert.h"
#include "proto/convert/spec_convert.h"
#include "tests/fuzz/targets/small_studio.h"

namespace penumbra::fuzzing {
namespace {

Step StepOf(const v1::SessionRequest& request) { return {kRequest, request.SerializeAsString()}; }

v1::Camera SomeCamera() { return ToProto(View{.camera = {.eye = {1, 2, 3}}}); }

Step Hello() {
  v1::SessionRequest request;
  v1::Hello& hello = *request.mutable_hello();
  hello.add_protocol_versions(1);
  hello.set_scene_id("studio");
  hello.set_mirror_scene(true);
  hello.set_client_name("penumbra");
  hello.mutable_resume()->set_incarnation(kIncarnation);
  hello.mutable_resume()->set_content_hash(kContentHash);
  hello.mutable_presence()->set_display_name("Ada");
  return StepOf(request);
}

Step CommitOf(uint64_t id, const SceneDelta& delta) {
  v1::SessionRequest request;
  request.mutable_commit()->set_commit_id(id);
  request.mutable_commit()->set_idempotency_key("key-" + std::to_string(id));
  *request.mutable_commit()->mutable_delta() = ToProto(delta);
  return StepOf(request);
}

// One of each technique.
Script Subscriptions() {
  Script script;
  for (const TechniqueParams& params : AllTechniques()) {
    ArtifactSpec spec{.params = params, .light_id = "lamp"};
    const SpecTarget target = InfoOf(params).target;
    if (target == SpecTarget::kReceiver) spec.receiver_id = "floor";
    if (target == SpecTarget::kPoints) {
      spec.points = PicturePixels{.camera = {.eye = {1, 2, 3}}, .width = 32, .height = 24};
    }
    v1::SessionRequest request;
    *request.mutable_subscribe()->mutable_spec() = ToProto(spec);
    request.mutable_subscribe()->set_subscription_id(script.size());
    request.mutable_subscribe()->set_initial_credit(4);
    script.push_back(StepOf(request));
  }
  return script;
}

Step SubscribeEach() {
  v1::SessionRequest request;
  v1::SubscribeEach& each = *request.mutable_subscribe_each();
  *each.mutable_technique() = ToProto(ArtifactSpec{.params = SoftTextureParams{}});
  each.add_light_ids("sun");
  each.add_receiver_ids("floor");
  return StepOf(request);
}

Script People() {
  v1::SessionRequest look, say, take, take_from, hand_over, release;
  *look.mutable_view_report()->mutable_camera() = SomeCamera();
  v1::Presence& presence = *say.mutable_presence();
  presence.set_display_name("Ada");
  presence.set_colour_rgb(0x3366cc);
  *presence.mutable_camera() = SomeCamera();
  presence.add_selected_ids("box");
  take.mutable_edit_control()->mutable_take();
  take_from.mutable_edit_control()->set_request_id(1);
  take_from.mutable_edit_control()->mutable_take()->set_from_id(kMe);
  hand_over.mutable_edit_control()->set_request_id(1);
  hand_over.mutable_edit_control()->mutable_hand_over()->set_participant_id(kMe);
  release.mutable_edit_control()->mutable_release()->set_keep_single_editor(true);
  return {StepOf(look),      StepOf(say),       StepOf(take),
          StepOf(take_from), StepOf(hand_over), StepOf(release)};
}

// A list of so many empty parts that they take much.
Step Crowd() {
  v1::SessionRequest request;
  auto& delta = *request.mutable_commit()->mutable_delta();
  for (int i = 0; i < 1'000; ++i) delta.add_upsert_lights();
  return {kBytes, request.SerializeAsString()};
}

Step Counters() {
  v1::SessionRequest request;
  request.mutable_credit()->set_updates(10);
  return StepOf(request);
}

}  // namespace

std::vector<Seed> SessionRequestSeeds() {
  return {{"hello", {Hello(), CommitOf(1, BoxAt(1)), Counters()}},
          {"commits", {CommitOf(1, StudioDelta()), CommitOf(2, BoxAt(2))}},
          {"subscriptions", Subscriptions()},
          {"each", {SubscribeEach()}},
          {"people", People()},
          {"crowd", {Crowd(), Hello()}}};
}

}  // namespace penumbra::fuzzing
