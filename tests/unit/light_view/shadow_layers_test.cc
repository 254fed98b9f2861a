// What is a blocker, and what lies behind it, in scenes where that is known.
#include "render/light_view/shadow_layers.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "render/light_view/light_face.h"
#include "render/light_view/ray_depth_source.h"
#include "render/light_view/shadowless_surfaces.h"
#include "render/light_view/view_fit.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {
namespace {

Instance Box(std::string id, Vec3 center, Vec3 half) {
  return {.id = std::move(id),
          .mesh = MeshOf(UnitBoxGeometry()),
          .world_from_mesh = Placed(center, half)};
}

Instance Sheet(std::string id, Vec3 center, Vec3 half) {
  return {.id = std::move(id),
          .mesh = MeshOf(UnitSquareGeometry()),
          .world_from_mesh = Placed(center, half)};
}

struct Seen {
  LightView view;
  ShadowLayers layers;

  // Of the pixel that sees a point.
  size_t At(Vec3 point) const {
    const DVec3 pixel = view.Project(DVec3(point));
    return static_cast<size_t>(pixel.y) * view.width + static_cast<size_t>(pixel.x);
  }
  bool IsBlocked(Vec3 point) const { return layers.blocked[At(point)] != 0; }
};

// From a light 4 m up, looking down with pixels of a few millimetres.
absl::StatusOr<Seen> LookDown(const SceneDelta& delta,
                              LightShape shape = SpotLight{.position = {0, 4, 0}},
                              std::stop_token stop = {}) {
  const auto scene = Scene::Empty("s")->Apply(delta).value();
  const auto all = WithAllSurfaces(*scene).value();
  tbb::task_arena arena(2);
  CasterBvhs bvhs;
  const Aabb bounds = all->Bounds();
  const LightFace face = FacesOf({.id = "l", .shape = shape}, bounds).at(0);
  const LightView view = CenterView(face, {&bounds, 1}, 0.005).value();
  DepthMap nearest;
  RayDepthSource source(bvhs.Of(*scene), arena);
  const auto drawn = source.Draw({&view, 1}, {}, [&](size_t, DepthMap map) {
    nearest = std::move(map);
    return absl::OkStatus();
  });
  EXPECT_TRUE(drawn.ok()) << drawn;
  auto layers = ShadowLayerTracer(*scene, *all, bvhs, arena).Trace(nearest, stop);
  if (!layers.ok()) return layers.status();
  return Seen{view, *std::move(layers)};
}

Seen Down(std::vector<Instance> instances) {
  return LookDown({.upsert_instances = std::move(instances)}).value();
}

const Instance kFloor = Sheet("floor", Vec3(0), Vec3(1.5f, 1, 1.5f));
const Instance kBox = Box("box", {0.5f, 1, 0}, {0.2f, 0.1f, 0.3f});
constexpr Vec3 kOnBox(0.5f, 1.1f, 0.1f), kBeside(-0.4f, 0, 0.2f);

TEST(ShadowLayersTest, WhatStandsBeforeAFloorIsABlocker) {
  const Seen seen = Down({kFloor, kBox});
  EXPECT_TRUE(seen.IsBlocked(kOnBox));
  EXPECT_FALSE(seen.IsBlocked(kBeside));
  const size_t at = seen.At(kOnBox);
  EXPECT_NEAR(seen.layers.first_receiver[at], 4, 1e-4);
  EXPECT_NEAR(seen.layers.last_receiver[at], 4, 1e-4);
  EXPECT_NEAR(seen.layers.before_first[at], 3.1, 1e-4);  // the box's far side
  EXPECT_NEAR(seen.layers.before_last[at], 3.1, 1e-4);
  EXPECT_EQ(seen.layers.first_receiver[seen.At(kBeside)], kNoDepth);
}

TEST(ShadowLayersTest, FromInfinitelyFarItIsTheSame) {
  const auto seen = LookDown({.upsert_instances = {kFloor, kBox}}, DistantLight{});
  ASSERT_TRUE(seen.ok());
  EXPECT_TRUE(seen->IsBlocked(kOnBox));
  EXPECT_FALSE(seen->IsBlocked(kBeside));
  const size_t at = seen->At(kOnBox);
  EXPECT_NEAR(seen->layers.last_receiver[at] - seen->layers.before_last[at], 0.9, 1e-4);
}

// The underside of a slab, and whatever a mirror makes of it, gets no light.
TEST(ShadowLayersTest, SolidsReceiveOnTheSideOfTheLight) {
  for (const float mirror : {1.0f, -1.0f}) {
    const Seen seen = Down({Box("slab", {0, -0.1f, 0}, {1.5f * mirror, 0.1f, 1.5f}), kBox});
    EXPECT_TRUE(seen.IsBlocked(kOnBox));
    EXPECT_FALSE(seen.IsBlocked(kBeside)) << mirror;
    EXPECT_NEAR(seen.layers.last_receiver[seen.At(kOnBox)], 4, 1e-4) << mirror;
  }
}

// Of a sheet both sides receive, whichever way it turns.
TEST(ShadowLayersTest, SheetsReceiveOnBothSides) {
  Instance turned = kFloor;
  turned.world_from_mesh[0] *= -1;
  const Seen seen = Down({turned, kBox});
  EXPECT_TRUE(seen.IsBlocked(kOnBox));
  EXPECT_FALSE(seen.IsBlocked(kBeside));
}

TEST(ShadowLayersTest, SurfacesBetweenAreToldApart) {
  const Seen seen = Down({kFloor, Box("table", {0.5f, 0.5f, 0}, {0.6f, 0.05f, 0.6f}), kBox});
  const size_t at = seen.At(kOnBox);
  EXPECT_NEAR(seen.layers.first_receiver[at], 3.45, 1e-4);
  EXPECT_NEAR(seen.layers.before_first[at], 3.1, 1e-4);
  EXPECT_NEAR(seen.layers.last_receiver[at], 4, 1e-4);
  EXPECT_NEAR(seen.layers.before_last[at], 3.55, 1e-4);
}

// What ends on a receiver has no far side that a ray meets, and its near side is lit.
TEST(ShadowLayersTest, WhatReceivesAtTheLastBlockerIsTold) {
  const Instance stands = Box("stand", {0.5f, 0.3f, 0}, {0.6f, 0.3f, 0.6f});
  const Seen touching = Down({kFloor, stands, kBox});
  const size_t at = touching.At(kOnBox);
  EXPECT_NEAR(touching.layers.before_last[at], 3.4, 1e-4);
  EXPECT_NEAR(touching.layers.receiver_at_last[at], 3.4, 1e-4);
  const Seen apart = Down({kFloor, Box("table", {0.5f, 0.5f, 0}, {0.6f, 0.05f, 0.6f}), kBox});
  EXPECT_NEAR(apart.layers.receiver_at_last[apart.At(kOnBox)], 3.45, 1e-4);
  const Seen alone = Down({kFloor, kBox});
  EXPECT_NEAR(alone.layers.receiver_at_last[alone.At(kOnBox)], 2.9, 1e-4);
}

TEST(ShadowLayersTest, FlagsAreObeyed) {
  Instance only_casts = kBox, glass = Sheet("glass", {0.5f, 0.5f, 0}, {0.6f, 1, 0.6f});
  only_casts.receives = false;
  glass.casts = false;
  const Seen seen = Down({kFloor, only_casts, glass});
  const size_t at = seen.At(kOnBox);
  EXPECT_NEAR(seen.layers.first_receiver[at], 3.5, 1e-4);
  EXPECT_NEAR(seen.layers.before_last[at], 3.1, 1e-4) << "glass blocks nothing";
  Instance no_receiver = kFloor;
  no_receiver.receives = false;
  // Nothing receives: what only casts is a blocker all the same, and the box shadows nothing.
  const Seen none = Down({no_receiver, kBox});
  EXPECT_TRUE(none.IsBlocked(kBeside));
  EXPECT_FALSE(none.IsBlocked(kOnBox));
}

TEST(ShadowLayersTest, ReceiversByThemselvesCount) {
  const auto seen =
      LookDown({.upsert_instances = {kBox}, .upsert_receivers = {FloorReceiver("receiver", 3, 8)}});
  ASSERT_TRUE(seen.ok());
  EXPECT_TRUE(seen->IsBlocked(kOnBox));
  EXPECT_NEAR(seen->layers.last_receiver[seen->At(kOnBox)], 4, 1e-4);
}

// Half of it over nothing: it casts a shadow elsewhere, and is in nobody's.
TEST(ShadowLayersTest, WhatHangsOverNothingIsABlockerIfItIsOneElsewhere) {
  const Instance small_floor = Sheet("floor", Vec3(0), Vec3(0.6f, 1, 1.5f));
  const Instance ball = Box("ball", {0.5f, 1, 0}, {0.4f, 0.1f, 0.3f});
  EXPECT_TRUE(Down({small_floor, ball}).IsBlocked({0.85f, 1.1f, 0}));
  // In the shadow of something, it is what shadows fall on.
  const Seen shadowed = Down({small_floor, ball, Box("speck", {0.3f, 1.6f, 0}, Vec3(0.03f))});
  EXPECT_FALSE(shadowed.IsBlocked({0.85f, 1.1f, 0}));
  EXPECT_TRUE(shadowed.IsBlocked({0.15f, 1.1f, 0}));
  // A floor over a cellar is none where the cellar ends.
  const Seen house = Down({kFloor, kBox, Box("cellar", {0, -1, 0}, {0.3f, 0.1f, 0.3f})});
  EXPECT_FALSE(house.IsBlocked({-1.2f, 0, 0.5f}));
  EXPECT_TRUE(house.IsBlocked({0.1f, 0, 0.1f}));
}

TEST(ShadowLayersTest, HolesOfMasksAreHoles) {
  Instance net = Sheet("net", {0, 1, 0}, Vec3(0.5f, 1, 0.5f));
  net.alpha_mask = AlphaMask::Create(2, 1, {0, 255}).value();  // clear where x < 0
  const Seen seen = Down({kFloor, net});
  EXPECT_TRUE(seen.IsBlocked({0.3f, 1, 0}));
  EXPECT_FALSE(seen.IsBlocked({-0.3f, 1, 0}));
}

TEST(ShadowLayersTest, ObeysAStop) {
  std::stop_source stop;
  stop.request_stop();
  const auto seen =
      LookDown({.upsert_instances = {kFloor}}, SpotLight{.position = {0, 4, 0}}, stop.get_token());
  EXPECT_EQ(seen.status().code(), absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace penumbra::testing
