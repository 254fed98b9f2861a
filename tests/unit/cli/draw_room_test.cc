#include "client/cli/draw_room.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "client/cli/open_engine.h"
#include "render/engine/compute_once.h"
#include "render/scene/field_error.h"
#include "tests/support/shapes.h"

namespace penumbra {
namespace {

using ::testing::HasSubstr;

constexpr uint32_t kSide = 600;

class DrawRoomTest : public ::testing::Test {
 protected:
  // A table over a floor with a box on it, so that there are two layers, and two lamps.
  void SetUp() override {
    engine_ = OpenEngine({.threads = 1}).value();
    scene_.emplace(TemporaryScene::Create(*engine_, "room").value());
    const auto box = testing::MeshOf(testing::UnitBoxGeometry());
    const auto add = [&](const char* id, Vec3 center, Vec3 half) {
      return Instance{.id = id, .mesh = box, .world_from_mesh = testing::Placed(center, half)};
    };
    SceneDelta delta{.upsert_instances = {add("floor", {0, -0.1f, 0}, {2, 0.1f, 2}),
                                          add("table", {0, 0.7f, 0}, {0.8f, 0.02f, 0.8f}),
                                          add("cup", {0, 1.3f, 0}, {0.1f, 0.05f, 0.1f})}};
    for (const char* id : {"a", "b"}) {
      delta.upsert_lights.push_back(
          {.id = id,
           .shape = DiskLight{.center = {0, 3, 0}, .normal = {0, -1, 0}, .radius = 0.2f}});
      wanted_.push_back(
          {.spec = {.params = ShadowWidthParams{.resolution = kSide}, .light_id = id}, .name = id});
    }
    ASSERT_TRUE(engine_->Commit(scene_->id(), delta).ok());
  }

  absl::Status Check(double bytes) {
    return CheckWidthsFit(wanted_, {.bytes = static_cast<uint64_t>(bytes), .device = "a device"},
                          [this](const PlannedShadow& shadow) {
                            ++computed_;
                            return ComputeOnce(*engine_, scene_->id(), shadow.spec);
                          });
  }
  // What they take once they are computed.
  double Bytes() {
    double words = 0;
    for (const PlannedShadow& shadow : wanted_) {
      const auto artifact = ComputeOnce(*engine_, scene_->id(), shadow.spec).value();
      for (const auto& face : std::get<ShadowWidthMap>(artifact->payload).faces) {
        words += static_cast<double>(face.near.widths.size()) * (face.far ? 4 : 2);
      }
    }
    return 4 * words;
  }

  std::unique_ptr<Engine> engine_;
  std::optional<TemporaryScene> scene_;
  std::vector<PlannedShadow> wanted_;
  int computed_ = 0;
};

TEST_F(DrawRoomTest, WhatFitsIsToldFromSmallMaps) {
  const double bytes = Bytes();
  EXPECT_EQ(Check(1.1 * bytes), absl::OkStatus());
  EXPECT_EQ(computed_, 2);
  const absl::Status status = Check(0.88 * bytes);
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(ErrorReason(status), "QUOTA_DRAW_BYTES");
  EXPECT_EQ(ErrorFieldPath(status), "--set resolution");
  EXPECT_THAT(std::string(status.message()),
              HasSubstr("found 600, at which the shadows of 2 light"));
  EXPECT_THAT(std::string(status.message()), HasSubstr("to draw with a device"));
  // The side whose square is 0.88 of theirs, less a doubt, to a multiple of 16.
  EXPECT_THAT(std::string(status.message()), HasSubstr("a resolution of 544 or less"));
  for (PlannedShadow& shadow : wanted_) {
    std::get<ShadowWidthParams>(shadow.spec.params).resolution = 544;
  }
  EXPECT_LE(Bytes(), 0.88 * bytes);
}

TEST_F(DrawRoomTest, NothingIsComputedWhereAnythingFits) {
  EXPECT_EQ(Check(2.0 * 6 * 16 * 1.25 * 1.25 * kSide * kSide), absl::OkStatus());
  EXPECT_EQ(computed_, 0);
}

TEST_F(DrawRoomTest, TracedPixelsTakeRoomToo) {
  const double bytes = Bytes();
  wanted_.push_back({.spec = {.params = CoherentRaytraceParams{},
                              .light_id = "a",
                              .points = PicturePixels{.width = 100, .height = 50}},
                     .name = "picture"});
  EXPECT_EQ(Check(1.2 * bytes + 20'000), absl::OkStatus());
  wanted_.back().spec.points = PicturePixels{.width = 1000, .height = 1000};
  EXPECT_THAT(std::string(Check(1.2 * bytes + 20'000).message()), HasSubstr("need at most"));
}

}  // namespace
}  // namespace penumbra
