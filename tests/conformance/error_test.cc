// Errors are the same on every engine, and leave everything as it was.
#include <limits>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "render/engine/compute_once.h"
#include "render/scene/field_error.h"
#include "tests/conformance/conformance.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

class ErrorTest : public ConformanceTest {
 protected:
  ErrorTest() : scene_(NewScene(stage_.delta())) {}

  void ExpectRefused(const SceneDelta& delta, absl::StatusCode code, const std::string& reason,
                     const std::string& fragment) {
    const auto before = engine_->Snapshot(scene_).value();
    const absl::Status status = engine_->Commit(scene_, delta).status();
    EXPECT_EQ(status.code(), code) << status;
    EXPECT_EQ(ErrorReason(status), reason);
    EXPECT_THAT(std::string(status.message()), HasSubstr(fragment));
    const auto after = engine_->Snapshot(scene_).value();
    EXPECT_EQ(after->revision(), before->revision());
    EXPECT_EQ(after->content_hash(), before->content_hash());
  }
  absl::Status ComputeStatus(const ArtifactSpec& spec) {
    return ComputeOnce(*engine_, scene_, spec).status();
  }

  const Stage stage_{.light = PointLight{.position = Vec3(0, 2, 0)},
                     .receiver = OddFloor(),
                     .occluders = {BoxOver(Vec3(0, 1, 0), Vec3(0.3f))}};
  const std::string scene_;
};

TEST_P(ErrorTest, RefusedCommitsLeaveTheSceneAsItWas) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  ExpectRefused({.upsert_lights = {{"light", PointLight{.position = Vec3(0, nan, 0)}}}},
                absl::StatusCode::kInvalidArgument, "NON_FINITE", "upsert_lights[0].position");
  ExpectRefused({.upsert_lights = {{"light", RectangleLight{.edge_u = Vec3(0.0f)}}}},
                absl::StatusCode::kInvalidArgument, "ZERO_AREA", "upsert_lights[0].edge_u");
  ExpectRefused({.remove_instances = {"nobody"}}, absl::StatusCode::kNotFound, "UNKNOWN_ID",
                "nobody");
  ExpectRefused({.upsert_receivers = {{.id = "r", .shape = PlanarInstance{"occluder0"}}}},
                absl::StatusCode::kFailedPrecondition, "NOT_PLANAR", "upsert_receivers[0]");
  // Valid in part, refused as a whole.
  ExpectRefused({.remove_instances = {"occluder0"}, .remove_lights = {"nobody"}},
                absl::StatusCode::kNotFound, "UNKNOWN_ID", "nobody");
  SceneDelta stale = stage_.delta();
  stale.base_revision = 0;
  ExpectRefused(stale, absl::StatusCode::kAborted, "STALE_BASE", "1");
  stale.base_revision = 7;
  ExpectRefused(stale, absl::StatusCode::kOutOfRange, "FUTURE_BASE", "7");
  EXPECT_LT(Mean(Visibilities(scene_, Spec(scene_))), 1) << "and it still computes";
}

TEST_P(ErrorTest, ScenesThatAreNotThereAreNamedAlike) {
  for (const absl::Status& status :
       {engine_->Snapshot("nowhere").status(), engine_->Commit("nowhere", stage_.delta()).status(),
        ComputeOnce(*engine_, "nowhere", Spec("nowhere")).status()}) {
    EXPECT_EQ(status.code(), absl::StatusCode::kNotFound) << status;
    EXPECT_EQ(ErrorReason(status), "UNKNOWN_ID");
    EXPECT_EQ(ErrorFieldPath(status), "scene_id");
    EXPECT_THAT(std::string(status.message()), StartsWith("scene_id: "));
    EXPECT_THAT(std::string(status.message()), HasSubstr("nowhere"));
  }
}

TEST_P(ErrorTest, SpecsThatCannotBeComputed) {
  ArtifactSpec spec = Spec(scene_);
  spec.light_id = "nobody";
  EXPECT_EQ(ComputeStatus(spec).code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(ComputeStatus(spec).message()), HasSubstr("nobody"));
  spec = Spec(scene_);
  spec.receiver_id = "nowhere";
  const bool takes_receivers = target() == SpecTarget::kReceiver;
  EXPECT_EQ(ComputeStatus(spec).code(),
            takes_receivers ? absl::StatusCode::kNotFound : absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(ComputeStatus(spec).message()),
              HasSubstr(takes_receivers ? "nowhere" : "receiver_id"));
  spec = Spec(scene_);
  spec.points = LightmapTexels{"nowhere", 4, 4};
  EXPECT_EQ(ComputeStatus(spec).code(), target() == SpecTarget::kPoints
                                            ? absl::StatusCode::kNotFound
                                            : absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(ComputeStatus(spec).message()), HasSubstr("points"));
  if (has_samples()) {
    EXPECT_EQ(ComputeStatus(Spec(scene_, 0)).code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(std::string(ComputeStatus(Spec(scene_, 0)).message()), HasSubstr("samples"));
    EXPECT_EQ(ComputeStatus(Spec(scene_, 100'000)).code(), absl::StatusCode::kInvalidArgument);
  }
  EXPECT_LT(Mean(Visibilities(scene_, Spec(scene_))), 1) << "others are not disturbed";
}

TEST_P(ErrorTest, ScenesThatAreNotThereOrThereTwice) {
  EXPECT_EQ(engine_->CreateScene(scene_).code(), absl::StatusCode::kAlreadyExists);
  EXPECT_EQ(engine_->CreateScene("../etc").code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(engine_->DeleteScene("nothing").code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(engine_->Commit("nothing", {}).status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(engine_->Snapshot("nothing").status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(ComputeOnce(*engine_, "nothing", Spec("nothing")).status().code(),
            absl::StatusCode::kNotFound);
  EXPECT_EQ(engine_->ListScenes().value().size(), 1u);
}

PENUMBRA_INSTANTIATE_CONFORMANCE(ErrorTest);

}  // namespace
}  // namespace penumbra::testing
