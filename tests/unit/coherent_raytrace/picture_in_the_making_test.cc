// What of a final picture is published while it is made, by a clock that the test sets.
#include "render/technique/coherent_raytrace/picture_in_the_making.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "render/technique/coherent_raytrace/coherent_raytrace.h"
#include "render/technique/coherent_raytrace/receiver_points.h"
#include "tests/support/shapes.h"

namespace penumbra {
namespace {

const ViewShadow& ViewOf(const Artifact& artifact) {
  return std::get<ViewShadow>(artifact.payload);
}

// Eight tiles of 32×32 points in a row, one point of which is not there.
class PictureInTheMakingTest : public ::testing::Test {
 protected:
  PictureInTheMakingTest() {
    points_ = NoPoints({256, 32});
    std::ranges::fill(points_.is_there, uint8_t{1});
    points_.is_there[5] = 0;
    field_.visible.assign(points_.size(), 3);
    field_.irradiance.assign(points_.size(), 0.1f);
    context_.progress = [this](Artifact artifact) {
      published_.push_back(std::move(artifact));
      now_ms_ += publishing_ms_;
    };
    context_.now_ms = [this] { return now_ms_; };
  }

  PictureInTheMaking Begin() const {
    ViewShadow view;
    view.light = {.id = "lamp", .shape = PointLight{.intensity = Vec3(2, 4, 8)}};
    view.radiance.emplace();
    ArtifactHeader header;
    header.samples_requested = 4;
    return PictureInTheMaking(std::move(header), std::move(view), points_, RadianceFormat::kHalf,
                              context_);
  }
  // Each tile takes `ms`.
  void AddTiles(PictureInTheMaking& picture, uint32_t count, double ms) {
    for (uint32_t k = 0; k < count; ++k, ++tiles_done_) {
      now_ms_ += ms;
      picture.Add({.tile = {32 * tiles_done_, 0, 32, 32},
                   .tiles_done = tiles_done_ + 1,
                   .tiles = 8,
                   .rays = 100 * (tiles_done_ + 1)},
                  field_);
    }
  }

  SurfacePoints points_;
  ShadowField field_;
  tbb::task_arena arena_{1};
  ComputeContext context_{.arena = arena_};
  std::vector<Artifact> published_;
  uint32_t tiles_done_ = 0;
  double now_ms_ = 1000, publishing_ms_ = 0;
};

TEST_F(PictureInTheMakingTest, PublishesWhatIsThereNowAndThen) {
  PictureInTheMaking picture = Begin();
  AddTiles(picture, 8, 100);
  ASSERT_EQ(published_.size(), 3u);  // of eight tiles every second one, not the last
  for (uint32_t k = 0; k < 3; ++k) {
    const ViewShadow& view = ViewOf(published_[k]);
    EXPECT_EQ(published_[k].header.pass, k);
    EXPECT_FALSE(published_[k].header.is_final);
    EXPECT_EQ(view.progress.fraction_done, 0.25 * (k + 1));
    EXPECT_EQ(view.progress.rays_traced, 200 * (k + 1));
    EXPECT_NEAR(view.progress.time_left_ms, 800 - 200 * (k + 1), 1e-9);
    // What was handed out stays as it was.
    EXPECT_EQ(view.coverage->CountInside(), 2048 * (k + 1) - 1);
    EXPECT_FALSE(view.coverage->At(5));
  }
  const Artifact last = std::move(picture).Finish(field_);
  EXPECT_TRUE(last.header.is_final);
  EXPECT_EQ(last.header.pass, 3u);
  EXPECT_EQ(ViewOf(last).coverage->CountInside(), 8 * 1024 - 1);
  EXPECT_EQ(ViewOf(last).visibility.counts[7], 3);
  EXPECT_EQ(ViewOf(last).progress.time_left_ms, 0);
}

TEST_F(PictureInTheMakingTest, RadianceIsRoundedOnceForAll) {
  PictureInTheMaking picture = Begin();
  AddTiles(picture, 2, 100);
  ASSERT_EQ(published_.size(), 1u);
  const Vec3 early = ViewOf(published_[0]).radiance->texels[0];
  const Artifact last = std::move(picture).Finish(field_);
  EXPECT_EQ(early, ViewOf(last).radiance->texels[0]);
  for (int c = 0; c < 3; ++c) {
    const float exact = 0.1f * static_cast<float>(2 << c);
    EXPECT_EQ(early[c], FloatFromHalf(HalfFromFloat(exact)));
  }
}

// What a picture of many points takes to copy must not take the time of computing it.
TEST_F(PictureInTheMakingTest, PublishesLessOftenWhereItTakesLong) {
  publishing_ms_ = 30;
  PictureInTheMaking picture = Begin();
  AddTiles(picture, 8, 200);
  // At 200 ms; then not within 20 times what it took, 600 ms.
  ASSERT_EQ(published_.size(), 3u);
  EXPECT_EQ(ViewOf(published_[1]).progress.fraction_done, 4 / 8.0);
  EXPECT_EQ(ViewOf(published_[2]).progress.fraction_done, 7 / 8.0);
}

TEST_F(PictureInTheMakingTest, WithoutAClockTilesTellTheTime) {
  context_.now_ms = nullptr;
  PictureInTheMaking picture = Begin();
  AddTiles(picture, 8, 0);
  EXPECT_EQ(published_.size(), 7u);
}

TEST(FinalPictureTest, BeginsWhereItIsAskedToAndReportsOnTheWay) {
  SceneDelta delta;
  delta.upsert_instances = {{.id = "floor",
                             .mesh = testing::MeshOf(testing::UnitSquareGeometry()),
                             .world_from_mesh = testing::Placed(Vec3(0), 4.0f)}};
  delta.upsert_lights = {{.id = "lamp", .shape = RectangleLight{.corner = {-0.5f, 3, -0.5f}}}};
  const auto scene = Scene::Empty("s")->Apply(delta).value();
  ArtifactSpec spec{CoherentRaytraceParams{.samples = 16}, "lamp"};
  spec.points = PicturePixels{.camera = {.eye = {0, 5, 0.1f}, .target = {0, 0, 0}},
                              .width = 256,
                              .height = 128,
                              .first = {.x = 200, .y = 100, .width = 8, .height = 8}};
  tbb::task_arena arena(1);
  std::vector<Artifact> published;
  ComputeContext context{.arena = arena};
  context.progress = [&](Artifact artifact) { published.push_back(std::move(artifact)); };
  const auto last = CoherentRaytrace().Compute(*scene, spec, context);
  ASSERT_TRUE(last.ok()) << last.status();
  ASSERT_GE(published.size(), 6u);
  const ViewShadow& first = ViewOf(published[0]);
  EXPECT_TRUE(first.coverage->At(100 * 256 + 200));
  EXPECT_FALSE(first.coverage->At(10 * 256 + 10));
  EXPECT_LT(first.progress.fraction_done, 0.2);
  EXPECT_GT(first.progress.fraction_done, 0);
}

TEST(TileOrderTest, IsByDistanceFromWhereItBegins) {
  const std::vector<PixelRect> tiles = TilesOf(128, 96);
  PicturePixels picture{.width = 128, .height = 96};
  EXPECT_EQ(tiles[TileOrder(picture, tiles)[0]], (PixelRect{32, 32, 32, 32}));
  EXPECT_EQ(tiles[TileOrder(picture, tiles)[1]], (PixelRect{64, 32, 32, 32}));
  picture.first = {.x = 100, .y = 70, .width = 4, .height = 4};
  EXPECT_EQ(tiles[TileOrder(picture, tiles)[0]], (PixelRect{96, 64, 32, 32}));
  EXPECT_EQ(tiles[TileOrder(picture, tiles).back()], (PixelRect{0, 0, 32, 32}));
}

}  // namespace
}  // namespace penumbra
