// Whole fields: against rays to every sample, in any order, on any number of threads.
#include "render/technique/coherent_raytrace/shadow_field.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "render/reference/light_integral.h"
#include "render/scene/field_error.h"
#include "render/technique/coherent_raytrace/light_proof.h"
#include "render/technique/coherent_raytrace/triangle_tracer.h"
#include "tests/support/random_scene.h"
#include "tests/support/shapes.h"

namespace penumbra {
namespace {

// Boxes on a floor, seen from above.
class ShadowFieldTest : public ::testing::Test {
 protected:
  ShadowFieldTest() {
    testing::Dice dice(3);
    SceneDelta delta;
    for (int i = 0; i < 12; ++i) {
      delta.upsert_instances.push_back(
          {.id = "box" + std::to_string(i),
           .mesh = testing::MeshOf(testing::UnitBoxGeometry()),
           .world_from_mesh =
               dice.AnyAffine(0.2f, dice.InCube(1) * Vec3(1, 0.4f, 1) + Vec3(0, 0.5f, 0))});
    }
    delta.upsert_instances.push_back({.id = "floor",
                                      .mesh = testing::MeshOf(testing::UnitSquareGeometry()),
                                      .world_from_mesh = testing::Placed(Vec3(0), 2.0f)});
    delta.upsert_lights = {
        {.id = "lamp", .shape = RectangleLight{.corner = {-0.5f, 3, -0.5f}}},
        {.id = "disk", .shape = DiskLight{.center = {0.2f, 3, 0}, .radius = 0.6f}},
        {.id = "ball", .shape = SphereLight{.center = {0, 3, 0.2f}}},
        {.id = "sun", .shape = DistantLight{.to_light = {0.4f, 1, 0.1f}, .angular_diameter = 0.3f}},
        {.id = "point", .shape = PointLight{.position = {0, 3, 0}}}};
    scene_ = Scene::Empty("s")->Apply(delta).value();
    tracer_ =
        std::make_unique<TriangleTracer>(bvhs_.Flat(*scene_), SurfaceOffset(scene_->Bounds()));
    points_ =
        VisiblePoints(
            *bvhs_.Of(*scene_, CasterBvhs::Instances::kAll),
            {.camera = {.eye = {1, 3, 3}, .target = {0, 0, 0}}, .width = 100, .height = 80}, arena_)
            .value();
  }

  ShadowField Compute(const AreaLight& light, const ShadowFieldSettings& settings,
                      int threads = 2) {
    tbb::task_arena arena(threads);
    return ComputeShadowField(light, points_, *tracer_, settings, arena).value();
  }
  const AreaLight& Light(const char* id) { return *scene_->lights().find(id)->second; }

  double Rmse(const ShadowField& a, const ShadowField& b) const {
    double sum2 = 0;
    for (size_t i = 0; i < points_.size(); ++i) {
      const double off = (double(a.visible[i]) - b.visible[i]) / a.sample_count;
      sum2 += off * off;
    }
    return std::sqrt(sum2 / static_cast<double>(a.points));
  }

  CasterBvhs bvhs_;
  tbb::task_arena arena_{2};
  std::shared_ptr<const Scene> scene_;
  std::unique_ptr<TriangleTracer> tracer_;
  SurfacePoints points_;
};

TEST_F(ShadowFieldTest, SameBitsForAnyThreadsAndAnyOrder) {
  const LightProof proof(Light("lamp"), *scene_, {.pixels = 256}, arena_);
  ShadowFieldSettings settings{.sampling = {.side = 8, .seed = 5}, .proof = &proof};
  const ShadowField one = Compute(Light("lamp"), settings, 1);
  settings.tile_order = [](std::span<const PixelRect> tiles) {
    std::vector<uint32_t> order(tiles.size());
    std::iota(order.rbegin(), order.rend(), 0u);
    return order;
  };
  for (const int threads : {1, 2, 4}) {
    const ShadowField field = Compute(Light("lamp"), settings, threads);
    EXPECT_EQ(field.visible, one.visible) << threads;
    EXPECT_EQ(field.irradiance, one.irradiance) << threads;
    EXPECT_EQ(field.counts.rays, one.counts.rays) << threads;
  }
  settings.sampling.seed = 6;
  EXPECT_NE(Compute(Light("lamp"), settings).visible, one.visible);
}

TEST_F(ShadowFieldTest, EverySwitchGivesNearlyWhatAllRaysGive) {
  for (const auto& [id, light] : scene_->lights()) {
    ShadowFieldSettings settings{.sampling = {.side = 8, .predicts = false}, .shades = false};
    const ShadowField all = Compute(*light, settings);
    EXPECT_GT(all.points, 3000u);
    const LightProof proof(*light, *scene_, {.pixels = 512}, arena_);
    settings.proof = &proof;
    EXPECT_LT(Rmse(Compute(*light, settings), all), 0.002) << id << ", proof alone";
    settings.sampling.predicts = true;
    const ShadowField coherent = Compute(*light, settings);
    EXPECT_LT(Rmse(coherent, all), 0.02) << id;
    settings.sampling.skips_known_rays = false;
    settings.exterior_turns = 1;
    const ShadowField exact = Compute(*light, settings);
    EXPECT_LT(Rmse(exact, all), 0.012) << id;
    if (id != "point") {
      EXPECT_LT(coherent.counts.rays, all.counts.rays * 2 / 3) << id;
    }
  }
}

// Equation (1), at points that see all of the light: the closed form itself; elsewhere against
// many samples, each with its own weight.
TEST_F(ShadowFieldTest, IrradianceIsThatOfTheVisiblePart) {
  const AreaLight& lamp = Light("lamp");
  const auto fine = Compute(lamp, {.sampling = {.side = 32, .predicts = false}});
  const LightSquare square(lamp);
  for (size_t i = 0; i < points_.size(); i += 97) {
    if (!points_.is_there[i]) continue;
    const SurfacePoint& point = points_.points[i];
    const DVec3 exact = IntegratedRadiance(lamp, DVec3(point.position), DVec3(point.normal));
    const double share = double(fine.visible[i]) / fine.sample_count;
    EXPECT_LE(fine.irradiance[i], exact.x * 1.0001) << i;
    if (fine.visible[i] == fine.sample_count) {
      EXPECT_NEAR(fine.irradiance[i], exact.x, 1e-5);
    }
    if (fine.visible[i] == 0) {
      EXPECT_EQ(fine.irradiance[i], 0);
    }
    if (point.normal.y > 0.99f) {
      EXPECT_NEAR(fine.irradiance[i] / exact.x, share, 0.12);
    }
  }
}

TEST_F(ShadowFieldTest, ReportsTilesAndStops) {
  std::stop_source stop;
  size_t reports = 0;
  ShadowFieldSettings settings{.sampling = {.side = 4}};
  settings.on_tile = [&](const TileDone& done, const ShadowField&) {
    EXPECT_EQ(done.tiles_done, ++reports);
    EXPECT_EQ(done.tiles, 12u);
    if (reports == 5) stop.request_stop();
  };
  tbb::task_arena one(1);
  const auto field =
      ComputeShadowField(Light("lamp"), points_, *tracer_, settings, one, stop.get_token());
  EXPECT_EQ(field.status().code(), absl::StatusCode::kCancelled);
  EXPECT_EQ(reports, 5u);
}

// Each point once, however rows and tiles divide them.
TEST_F(ShadowFieldTest, ListsOfAnyLengthAreComputed) {
  std::vector<SurfacePoint> seen;
  for (size_t i = 0; i < points_.size(); ++i) {
    if (points_.is_there[i]) seen.push_back(points_.points[i]);
  }
  for (const uint32_t count : {1u, 31u, 32u, 33u, 1'000u, 1'025u, 3'000u}) {
    SurfacePoints list{.width = count, .height = 1};
    list.points.assign(seen.begin(), seen.begin() + count);
    list.is_there.assign(count, 1);
    if (count > 40) list.is_there[40] = 0;
    const uint32_t there = count - (count > 40);
    const auto compute = [&](bool predicts) {
      return ComputeShadowField(Light("lamp"), list, *tracer_,
                                {.sampling = {.side = 8, .predicts = predicts}}, arena_)
          .value();
    };
    const ShadowField all = compute(false), coherent = compute(true);
    EXPECT_EQ(all.points, there);
    EXPECT_EQ(coherent.points, there);
    EXPECT_LE(coherent.counts.rays, all.counts.rays);
    double sum = 0;
    for (uint32_t i = 0; i < count; ++i) {
      sum += std::abs(double(all.visible[i]) - coherent.visible[i]) / 64;
    }
    EXPECT_LT(sum / count, 0.01) << count;
  }
}

// Of points of which each is anywhere but near the one before it.
TEST_F(ShadowFieldTest, ListsInNoOrderAreAsGoodAsOthers) {
  std::vector<SurfacePoint> shuffled;
  for (size_t i = 0; i < points_.size(); ++i) {
    const auto& [position, normal] = points_.points[i];
    if (points_.is_there[i]) shuffled.push_back({position, normal});
  }
  testing::Dice dice(5);
  for (size_t i = shuffled.size(); i > 1; --i) {
    std::swap(shuffled[i - 1], shuffled[dice.Below(static_cast<uint32_t>(i))]);
  }
  const auto given = std::make_shared<const std::vector<SurfacePoint>>(std::move(shuffled));
  const SurfacePoints list = ListedPoints({.points = given});
  EXPECT_FALSE(list.order.empty());
  EXPECT_LT(SpacingOf(list), 0.1f);
  for (const char* id : {"lamp", "sun"}) {
    const auto compute = [&](bool predicts) {
      return ComputeShadowField(Light(id), list, *tracer_,
                                {.sampling = {.side = 16, .predicts = predicts}}, arena_)
          .value();
    };
    const ShadowField all = compute(false), coherent = compute(true);
    double sum2 = 0;
    for (size_t i = 0; i < list.size(); ++i) {
      const double off = (double(all.visible[i]) - coherent.visible[i]) / 256;
      sum2 += off * off;
    }
    EXPECT_LT(std::sqrt(sum2 / list.size()), 0.002) << id;
    EXPECT_LT(coherent.counts.rays, all.counts.rays / 2) << id;
  }
}

TEST_F(ShadowFieldTest, NoPointsAndOddSidesAreHandled) {
  const SurfacePoints none;
  const auto empty =
      ComputeShadowField(Light("lamp"), none, *tracer_, {.sampling = {.side = 4}}, arena_);
  ASSERT_TRUE(empty.ok());
  EXPECT_TRUE(empty->visible.empty());
  for (const uint32_t side : {0u, 33u}) {
    const auto refused =
        ComputeShadowField(Light("lamp"), points_, *tracer_, {.sampling = {.side = side}}, arena_);
    EXPECT_EQ(refused.status().code(), absl::StatusCode::kInvalidArgument);
    EXPECT_EQ(ErrorFieldPath(refused.status()), "samples.side");
  }
}

// Under a half plane: of a lamp 1 m wide and 2 m high, half a metre beyond −x is seen.
constexpr int kSide = 96;
SurfacePoints PenumbraGrid() {
  SurfacePoints grid{.width = kSide, .height = kSide};
  for (int i = 0; i < kSide * kSide; ++i) {
    const Vec3 p(-0.3f + 0.6f * (i % kSide) / kSide, 0, 0.5f * (i / kSide) / kSide);
    grid.points.push_back({p, {0, 1, 0}});
    grid.is_there.push_back(1);
  }
  return grid;
}

// Banding would be an error that neighbours share.
TEST_F(ShadowFieldTest, ErrorInASmoothPenumbraIsNoise) {
  SceneDelta delta;
  delta.upsert_instances = {{.id = "half",
                             .mesh = testing::MeshOf(testing::UnitSquareGeometry()),
                             .world_from_mesh = testing::Placed(Vec3(-50, 1, 0), 50.0f)}};
  const auto scene = Scene::Empty("s")->Apply(delta).value();
  const TriangleTracer tracer(bvhs_.Flat(*scene), 1e-4f);
  const SurfacePoints grid = PenumbraGrid();
  const AreaLight lamp{.id = "l", .shape = RectangleLight{.corner = {-0.5f, 2, -0.5f}}};
  const LightProof proof(lamp, *scene, {.pixels = 512}, arena_);
  const auto field = ComputeShadowField(
      lamp, grid, tracer, {.sampling = {.side = 8}, .shades = false, .proof = &proof}, arena_);
  std::vector<double> error;
  for (int i = 0; i < kSide * kSide; ++i) {
    const double share = 0.5 + double(grid.points[i].position.x);
    error.push_back(field->visible[i] / 64.0 - share);
  }
  const double mean = std::accumulate(error.begin(), error.end(), 0.0) / error.size();
  EXPECT_NEAR(mean, 0, 0.01);
  double variance = 0;
  for (double& e : error) e -= mean, variance += e * e / error.size();
  EXPECT_LT(std::sqrt(variance), 0.04);
  for (int lag = 3; lag <= 24; ++lag) {
    double along = 0, down = 0;
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x + lag < kSide; ++x) {
        along += error[y * kSide + x] * error[y * kSide + x + lag];
        down += error[x * kSide + y] * error[(x + lag) * kSide + y];
      }
    }
    const double pairs = kSide * double(kSide - lag);
    EXPECT_LT(std::abs(along / pairs / variance), 0.1) << lag;
    EXPECT_LT(std::abs(down / pairs / variance), 0.1) << lag;
  }
}

}  // namespace
}  // namespace penumbra
