// Deltas of a client, from the wire to the scene: what is refused has changed nothing, what is
// applied is whole, within the limits, hashed as it is, and can be told to others.

#include <algorithm>
#include <string>
#include <utility>

#include "penumbra/v1/scene.pb.h"
#include "proto/convert/scene_convert.h"
#include "render/scene/blob.h"
#include "render/scene/scene.h"
#include "render/scene/scene_difference.h"
#include "tests/fuzz/kit/require.h"
#include "tests/fuzz/kit/target.h"
#include "tests/fuzz/targets/scene_rules.h"
#include "tests/fuzz/targets/small_studio.h"
#include "tests/support/shapes.h"

namespace penumbra::fuzzing {
namespace {

SceneDelta Reversed(SceneDelta delta) {
  std::ranges::reverse(delta.upsert_instances);
  std::ranges::reverse(delta.upsert_lights);
  std::ranges::reverse(delta.upsert_receivers);
  std::ranges::reverse(delta.remove_instances);
  std::ranges::reverse(delta.remove_lights);
  std::ranges::reverse(delta.remove_receivers);
  return delta;
}

class SceneDeltas final : public Target {
 public:
  std::span<const StepKind> kinds() const override { return kinds_; }
  void Run(const Script& script) override;
  std::vector<Seed> Seeds() override;

 private:
  using Snapshot = std::shared_ptr<const Scene>;

  Snapshot Try(const Snapshot& before, const v1::SceneDelta& proto, const KnownBlobs& blobs);
  void CheckApplied(const Scene& before, const SceneDelta& delta, const Scene& after,
                    const KnownBlobs& blobs) const;
  void CheckTold(const Scene& from, const Scene& to, const KnownBlobs& blobs) const;

  const SceneLimits limits_ = SmallLimits();
  const StepKind kinds_[2] = {{"delta", &v1::SceneDelta::default_instance()}, {"blob"}};
};

void SceneDeltas::Run(const Script& script) {
  KnownBlobs blobs = StudioBlobs();
  Snapshot scene = Scene::Empty("studio");
  for (const Step& step : script) {
    if (step.kind % 2 == 1) {
      const auto blob = DecodeBlob(std::as_bytes(std::span(step.payload)), limits_);
      if (blob.ok()) blobs.Add(*blob);
      continue;
    }
    v1::SceneDelta proto;
    if (proto.ParseFromString(step.payload)) scene = Try(scene, proto, blobs);
  }
}

SceneDeltas::Snapshot SceneDeltas::Try(const Snapshot& before, const v1::SceneDelta& proto,
                                       const KnownBlobs& blobs) {
  const auto delta = FromProto(proto, blobs);
  Count(delta.ok());
  if (!delta.ok()) {
    RequireRefusal(delta.status());
    return before;
  }
  const ContentHash hash = before->content_hash();
  const auto after = before->Apply(*delta, limits_);
  Count(after.ok());
  Require(before->content_hash() == hash && HashAnew(*before) == hash, "a snapshot stays as it is");
  if (!after.ok()) {
    RequireNamedRefusal(after.status());
    return before;
  }
  CheckApplied(*before, *delta, **after, blobs);
  return *after;
}

void SceneDeltas::CheckApplied(const Scene& before, const SceneDelta& delta, const Scene& after,
                               const KnownBlobs& blobs) const {
  Require(after.revision() == before.revision() + 1, "a commit makes the next revision");
  const auto reversed = before.Apply(Reversed(delta), limits_);
  Require(reversed.ok() && (*reversed)->content_hash() == after.content_hash(),
          "the order within a delta means nothing");
  SceneDelta late = delta;
  late.base_revision = before.revision();
  const auto again = after.Apply(late, limits_);
  Require(again.status().code() == absl::StatusCode::kAborted, "a base that is behind is told");
  CheckTold(before, after, blobs);
  CheckTold(after, before, blobs);
  CheckTold(*Scene::Empty("studio"), after, blobs);
  RequireRules(after, limits_);
}

// A mirror that is told the difference, in pieces, has the same scene.
void SceneDeltas::CheckTold(const Scene& from, const Scene& to, const KnownBlobs& blobs) const {
  const SceneDelta difference = Difference(from, to);
  Require(difference.empty() == (from.content_hash() == to.content_hash()),
          "equal hashes are equal scenes");
  v1::SceneDelta told;
  for (const v1::SceneDelta& piece : ToProtoPieces(difference, 300)) {
    v1::SceneDelta received;
    Require(received.ParseFromString(piece.SerializeAsString()), "what is told can be read");
    told.MergeFrom(received);
  }
  const auto delta = FromProto(told, blobs);
  Require(delta.ok(), "a difference can be told: " + delta.status().ToString());
  const auto mirror = from.Apply(*delta, limits_);
  Require(mirror.ok(), "a difference applies: " + mirror.status().ToString());
  Require((*mirror)->content_hash() == to.content_hash(), "a mirror has the same scene");
}

v1::SceneDelta Removals() {
  v1::SceneDelta delta;
  delta.add_remove_receivers("side");
  delta.add_remove_instances("box");
  delta.add_remove_lights("sun");
  return delta;
}

v1::SceneDelta EverySurface() {
  v1::SceneDelta delta;
  delta.set_base_revision(1);
  auto& request = *delta.mutable_receive_on_planar_surfaces();
  request.set_min_area_m2(0.1);
  request.set_texels_per_metre(4);
  request.set_max_receivers(5);
  return delta;
}

std::string Serialized(const v1::SceneDelta& delta) { return delta.SerializeAsString(); }

std::vector<Seed> SceneDeltas::Seeds() {
  const std::string studio = Serialized(ToProto(StudioDelta()));
  const auto bytes = EncodeBlob(testing::BallGeometry(5, 3));
  const std::string ball(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  SceneDelta with_ball = BoxAt(1);
  with_ball.upsert_instances[0].mesh = testing::MeshOf(testing::BallGeometry(5, 3));
  return {
      {"studio", {{0, studio}}},
      {"edits", {{0, studio}, {0, Serialized(ToProto(BoxAt(1)))}, {0, Serialized(Removals())}}},
      {"surfaces", {{0, studio}, {0, Serialized(EverySurface())}}},
      {"ball", {{1, ball}, {0, studio}, {0, Serialized(ToProto(with_ball))}}},
  };
}

}  // namespace

Target& TheTarget() {
  static SceneDeltas target;
  return target;
}

}  // namespace penumbra::fuzzing
