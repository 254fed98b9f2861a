// Of the jobs that wait, those of receivers that viewers see most of run first.
#include <latch>
#include <mutex>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "render/engine/local_engine.h"
#include "render/scene/field_error.h"
#include "tests/unit/engine/scripted_technique.h"

namespace penumbra::testing {
namespace {

Receiver Patch(std::string id, Vec3 origin, float side) {
  return {.id = std::move(id),
          .shape = Parallelogram{
              .origin = origin, .edge_u = Vec3(side, 0, 0), .edge_v = Vec3(0, 0, -side)}};
}

const View kFromAbove{.camera = {.eye = Vec3(0, 5, 5), .target = Vec3(0, 0, 0)}};

// One runner, which the first job holds until it may go.
class ViewOrderTest : public ::testing::Test {
 protected:
  ViewOrderTest() {
    EXPECT_TRUE(engine_.CreateScene("s").ok());
    SceneDelta delta = LampAndFloor();
    delta.upsert_receivers = {Patch("first", Vec3(0), 1), Patch("unseen", Vec3(100, -1, 0), 1),
                              Patch("small", Vec3(0, -1, 0), 1), Patch("large", Vec3(0, -1, 0), 4),
                              Patch("behind", Vec3(0, -1, 50), 1)};
    EXPECT_TRUE(engine_.Commit("s", delta).ok());
  }

  void Follow(const std::string& receiver_id) {
    ArtifactSpec spec = LampOnFloor();
    spec.receiver_id = receiver_id;
    subscriptions_.push_back(engine_.Subscribe("s", spec, log_.Callback()).value());
  }

  std::latch holds_{1}, may_go_{1};
  std::mutex mutex_;
  std::vector<std::string> order_;
  const FunctionTechnique technique_{
      [this](const Scene& scene, const ArtifactSpec& spec, const ComputeContext&) {
        if (spec.receiver_id == "first") {
          holds_.count_down();
          may_go_.wait();
        }
        std::lock_guard lock(mutex_);
        order_.push_back(spec.receiver_id);
        return LabelledArtifact(scene, 0, true);
      }};
  LocalEngine engine_{[this] {
    LocalEngineOptions options = OptionsFor(technique_);
    options.runner_threads = 1;
    return options;
  }()};
  UpdateLog log_;
  std::vector<std::unique_ptr<Subscription>> subscriptions_;
};

// What nobody sees comes last, in the order of asking.
TEST_F(ViewOrderTest, WhatPeopleLookAtComesFirst) {
  Follow("first");
  holds_.wait();
  for (const char* id : {"unseen", "small", "large", "behind"}) Follow(id);
  EXPECT_TRUE(engine_.ReportView("s", "me", kFromAbove).ok());
  may_go_.count_down();
  log_.AwaitCount(5);
  EXPECT_EQ(order_, (std::vector<std::string>{"first", "large", "small", "unseen", "behind"}));
}

TEST_F(ViewOrderTest, AViewThatIsNoneIsRefused) {
  may_go_.count_down();
  View blind = kFromAbove;
  blind.camera.fov_y_deg = 0;
  const absl::Status status = engine_.ReportView("s", "me", blind);
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(ErrorFieldPath(status), "camera.fov_y_deg");
  View far = kFromAbove;
  far.camera.eye.y = 1e30f;
  EXPECT_EQ(ErrorReason(engine_.ReportView("s", "me", far)), "OUT_OF_BOUNDS");
  EXPECT_EQ(engine_.ReportView("ghost", "me", kFromAbove).code(), absl::StatusCode::kNotFound);
}

TEST(ViewersTest, AreCounted) {
  LocalEngine engine({.max_viewers_per_scene = 2});
  ASSERT_TRUE(engine.CreateScene("s").ok());
  const View view{};
  EXPECT_TRUE(engine.ReportView("s", "a", view).ok());
  EXPECT_TRUE(engine.ReportView("s", "b", view).ok());
  EXPECT_TRUE(engine.ReportView("s", "a", view).ok()) << "again is not another";
  EXPECT_EQ(ErrorReason(engine.ReportView("s", "c", view)), "QUOTA_VIEWERS");
  EXPECT_TRUE(engine.ReportView("s", "b", std::nullopt).ok());
  EXPECT_TRUE(engine.ReportView("s", "c", view).ok());
}

}  // namespace
}  // namespace penumbra::testing
