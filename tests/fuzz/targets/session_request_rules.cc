#include "tests/fuzz/targets/session_request_rules.h"

#include <algorithm>
#include <cstdint>
#include <span>

#include "proto/convert/geometry_convert.h"
#include "proto/convert/spec_convert.h"
#include "render/technique/technique.h"
#include "server/session/bounded_parse.h"
#include "tests/fuzz/kit/require.h"

namespace penumbra::fuzzing {
namespace {

std::span<const uint8_t> BytesOfText(const std::string& text) {
  return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
}

void RequireSameSpec(const v1::ArtifactSpec& proto, const Scene& scene) {
  const auto spec = FromProto(proto);
  if (!spec.ok()) return RequireNamedRefusal(spec.status());
  const auto target = TargetOf(proto);
  Require(target.ok() && *target == InfoOf(spec->params).target, "a spec is for a target");
  const v1::ArtifactSpec told = ToProto(*spec);
  const auto again = FromProto(told);
  Require(again.ok(), "a spec can be told: " + again.status().ToString());
  // As bytes: what is no number is not equal to itself.
  Require(ToProto(*again).SerializeAsString() == told.SerializeAsString(), "and stays the same");
  Require(SpecKey(*again) == SpecKey(*spec), "equal specs have one key");
  const absl::Status check = TechniqueFor(spec->params).Check(scene, *spec);
  if (!check.ok()) RequireNamedRefusal(check);
}

// As a subscription for each; one will do here.
void RequireSameSpecs(const v1::SubscribeEach& request, const Scene& scene) {
  const auto target = TargetOf(request.technique());
  if (!target.ok()) return RequireNamedRefusal(target.status());
  v1::ArtifactSpec one = request.technique();
  one.set_light_id(request.light_ids().empty() ? "lamp" : request.light_ids(0));
  if (*target == SpecTarget::kReceiver) {
    one.set_receiver_id(request.receiver_ids().empty() ? "floor" : request.receiver_ids(0));
  }
  RequireSameSpec(one, scene);
}

void RequireSameView(const v1::Camera& camera, const Scene& scene) {
  const auto view = FromProto(camera);
  if (!view.ok()) return RequireNamedRefusal(view.status());
  const auto again = FromProto(ToProto(*view));
  Require(again.ok() && again->camera == view->camera && again->aspect == view->aspect,
          "a view stays the same");
  for (const auto& [id, receiver] : scene.receivers()) {
    const auto patch = scene.ResolveReceiver(id);
    if (!patch.ok()) continue;
    const double share = ViewedShare(*view, patch->patch);
    Require(share >= 0 && share <= 1, "the part of a picture that something fills is one");
  }
}

}  // namespace

void RequireBounded(const std::string& bytes, const ServerLimits& limits,
                    const v1::SessionRequest& request) {
  const uint64_t most = std::max<uint64_t>(limits.always_allowed_parsed_bytes,
                                           uint64_t{bytes.size()} * limits.parsed_bytes_per_byte);
  // Besides: numbers of one byte that take four, in lists that have room for as many more.
  Require(request.SpaceUsedLong() <= most + 16 * bytes.size() + sizeof(v1::SessionRequest),
          "few bytes do not become much memory");
  v1::SessionRequest known = request;
  known.DiscardUnknownFields();
  const std::string again = request.SerializeAsString();
  Require(known.SerializeAsString() == again, "unknown fields are dropped");
  // In other bytes, which may be too few for what is in them, or too many.
  v1::SessionRequest reread;
  const absl::Status status = ParseBounded(BytesOfText(again), limits, reread);
  Require(status.ok() || absl::IsResourceExhausted(status), "what is taken is taken again");
  Require(!status.ok() || reread.SerializeAsString() == again, "and says the same");
}

void RequireMeaning(const v1::SessionRequest& request, const Scene& scene) {
  if (request.has_subscribe()) RequireSameSpec(request.subscribe().spec(), scene);
  if (request.has_subscribe_each()) RequireSameSpecs(request.subscribe_each(), scene);
  if (request.view_report().has_camera()) RequireSameView(request.view_report().camera(), scene);
  if (!request.hello().has_resume()) return;
  const std::string& bytes = request.hello().resume().content_hash();
  const auto hash = HashFromProto(bytes, "hello.resume.content_hash");
  if (!hash.ok()) return RequireNamedRefusal(hash.status());
  Require(ToProto(*hash) == bytes, "a hash is its bytes");
}

}  // namespace penumbra::fuzzing
