#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "render/scene/field_error.h"
#include "render/scene/scene.h"
#include "tests/support/shapes.h"

namespace penumbra {
namespace {

using ::testing::HasSubstr;

Instance Box(std::string id, Vec3 position = Vec3(0, 1, 0)) {
  return {.id = std::move(id),
          .mesh = testing::MeshOf(testing::UnitBoxGeometry()),
          .world_from_mesh = testing::Placed(position)};
}

AreaLight Lamp(std::string id) {
  return {.id = std::move(id), .shape = RectangleLight{.corner = Vec3(0, 4, 0)}};
}

std::shared_ptr<const Scene> Studio() {
  SceneDelta delta;
  delta.upsert_instances = {
      Box("a"),
      Box("b", Vec3(3, 1, 0)),
      {.id = "floor", .mesh = testing::MeshOf(testing::UnitSquareGeometry())}};
  delta.upsert_lights = {Lamp("lamp")};
  delta.upsert_receivers = {testing::FloorReceiver("patch", 6, 64),
                            {.id = "on-floor", .shape = PlanarInstance{"floor"}}};
  return Scene::Empty("studio")->Apply(delta).value();
}

TEST(SceneApply, CountsRevisionsAndSharesWhatStays) {
  const auto first = Studio();
  EXPECT_EQ(first->revision(), 1u);
  SceneDelta move;
  move.upsert_instances = {Box("a", Vec3(0, 2, 0))};
  const auto second = first->Apply(move).value();
  EXPECT_EQ(second->revision(), 2u);
  EXPECT_EQ(first->FindInstance("a")->world_from_mesh[3].y, 1);
  EXPECT_EQ(second->FindInstance("a")->world_from_mesh[3].y, 2);
  EXPECT_EQ(first->FindInstance("b"), second->FindInstance("b"));
  EXPECT_EQ(&first->lights(), &second->lights());
  EXPECT_NE(first->content_hash(), second->content_hash());
}

TEST(SceneApply, ForgetsUndoneEdits) {
  const auto scene = Studio();
  SceneDelta move, back, remove, readd;
  move.upsert_instances = {Box("a", Vec3(9, 2, 0))};
  back.upsert_instances = {Box("a")};
  remove.remove_instances = {"b"};
  remove.remove_lights = {"lamp"};
  readd.upsert_instances = {Box("b", Vec3(3, 1, 0))};
  readd.upsert_lights = {Lamp("lamp")};
  auto now = scene;
  for (const SceneDelta* delta : {&move, &remove, &back, &readd}) now = now->Apply(*delta).value();
  EXPECT_EQ(now->revision(), 5u);
  EXPECT_EQ(now->content_hash(), scene->content_hash());
}

TEST(SceneApply, KeepsToItsBase) {
  const auto scene = Studio();
  SceneDelta delta;
  delta.remove_instances = {"a"};
  delta.base_revision = 0;
  auto stale = scene->Apply(delta);
  EXPECT_EQ(stale.status().code(), absl::StatusCode::kAborted);
  EXPECT_EQ(ErrorReason(stale.status()), "STALE_BASE");
  EXPECT_THAT(std::string(stale.status().message()), HasSubstr("need the current revision 1"));
  delta.base_revision = std::numeric_limits<uint64_t>::max();
  EXPECT_EQ(scene->Apply(delta).status().code(), absl::StatusCode::kOutOfRange);
  delta.base_revision = 1;
  EXPECT_TRUE(scene->Apply(delta).ok());
}

struct Refusal {
  std::string what;
  std::function<void(SceneDelta&)> spoil;
  absl::StatusCode code;
  std::string reason;
  std::string field;
};

class SceneRefusalTest : public ::testing::TestWithParam<Refusal> {};

TEST_P(SceneRefusalTest, NamesTheFieldAndChangesNothing) {
  const Refusal& refusal = GetParam();
  const auto scene = Studio();
  SceneDelta delta;
  delta.upsert_instances = {Box("good")};  // valid, and must not get in either
  refusal.spoil(delta);
  const auto next = scene->Apply(delta);
  ASSERT_FALSE(next.ok());
  EXPECT_EQ(next.status().code(), refusal.code) << next.status();
  EXPECT_EQ(ErrorReason(next.status()), refusal.reason) << next.status();
  EXPECT_EQ(ErrorFieldPath(next.status()), refusal.field) << next.status();
  EXPECT_EQ(scene->content_hash(), Studio()->content_hash());
  EXPECT_FALSE(scene->FindInstance("good"));
}

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;

std::function<void(SceneDelta&)> WithLight(LightShape shape) {
  return [shape](SceneDelta& d) { d.upsert_lights = {{.id = "l", .shape = shape}}; };
}
std::function<void(SceneDelta&)> WithReceiver(std::function<void(Receiver&)> spoil) {
  return [spoil](SceneDelta& d) {
    d.upsert_receivers = {testing::FloorReceiver("r", 2, 8)};
    spoil(d.upsert_receivers[0]);
  };
}
std::function<void(SceneDelta&)> WithInstance(std::function<void(Instance&)> spoil) {
  return [spoil](SceneDelta& d) {
    d.upsert_instances.push_back(Box("x"));
    spoil(d.upsert_instances[1]);
  };
}

const Refusal kRefusals[] = {
    {"NanTransform", WithInstance([](Instance& i) { i.world_from_mesh[3].x = kNan; }), kInvalid,
     "NON_FINITE", "upsert_instances[1].world_from_mesh"},
    {"FarAway", WithInstance([](Instance& i) {
       i.world_from_mesh[0].x = 9e8f;
       i.world_from_mesh[3].x = 5e8f;
     }),
     kInvalid, "OUT_OF_BOUNDS", "upsert_instances[1].world_from_mesh"},
    {"NoMesh", WithInstance([](Instance& i) { i.mesh = nullptr; }), kInvalid, "MISSING_MESH",
     "upsert_instances[1].mesh"},
    {"NegativeColour", WithInstance([](Instance& i) { i.color.y = -1; }), kInvalid, "RANGE",
     "upsert_instances[1].color"},
    {"MaskWithoutUvs",
     WithInstance([](Instance& i) { i.alpha_mask = *AlphaMask::Create(1, 1, {255}); }), kInvalid,
     "MISSING_UVS", "upsert_instances[1].alpha_mask"},
    {"EmptyId", WithInstance([](Instance& i) { i.id = ""; }), kInvalid, "BAD_ID",
     "upsert_instances[1].id"},
    {"PathId", WithInstance([](Instance& i) { i.id = "../x"; }), kInvalid, "BAD_ID",
     "upsert_instances[1].id"},
    {"LongId", WithInstance([](Instance& i) { i.id = std::string(129, 'x'); }), kInvalid, "BAD_ID",
     "upsert_instances[1].id"},
    {"TwiceInADelta", WithInstance([](Instance& i) { i.id = "good"; }), kInvalid, "DUPLICATE_ID",
     "upsert_instances[1].id"},
    {"RemoveUnknown",
     [](SceneDelta& d) {
       d.remove_lights = {"lamp", "moon"};
     },
     absl::StatusCode::kNotFound, "UNKNOWN_ID", "remove_lights[1]"},
    {"RemoveTwice",
     [](SceneDelta& d) {
       d.remove_instances = {"a", "a"};
     },
     kInvalid, "DUPLICATE_ID", "remove_instances[1]"},
    {"ZeroEdge", WithLight(RectangleLight{.edge_v = Vec3(0)}), kInvalid, "ZERO_AREA",
     "upsert_lights[0].edge_v"},
    {"ParallelEdges", WithLight(RectangleLight{.edge_u = Vec3(1, 2, 3), .edge_v = Vec3(2, 4, 6)}),
     kInvalid, "ZERO_AREA", "upsert_lights[0].edge_v"},
    {"NanRadiance", WithLight(RectangleLight{.radiance = Vec3(kNan)}), kInvalid, "NON_FINITE",
     "upsert_lights[0].radiance"},
    {"NegativeRadiance", WithLight(SphereLight{.radiance = Vec3(0, -1, 0)}), kInvalid, "RANGE",
     "upsert_lights[0].radiance"},
    {"ZeroRadius", WithLight(SphereLight{.radius = 0}), kInvalid, "ZERO_AREA",
     "upsert_lights[0].radius"},
    {"NegativeRadius", WithLight(DiskLight{.radius = -1}), kInvalid, "ZERO_AREA",
     "upsert_lights[0].radius"},
    {"HugeSphere", WithLight(SphereLight{.radius = 2e9f}), kInvalid, "OUT_OF_BOUNDS",
     "upsert_lights[0].radius"},
    {"HugeDisk", WithLight(DiskLight{.radius = 2e9f}), kInvalid, "OUT_OF_BOUNDS",
     "upsert_lights[0].radius"},
    {"NoDirection", WithLight(DistantLight{.to_light = Vec3(0)}), kInvalid, "ZERO_LENGTH",
     "upsert_lights[0].to_light"},
    {"InsideOutCone", WithLight(SpotLight{.inner_angle = 0.9f, .outer_angle = 0.5f}), kInvalid,
     "RANGE", "upsert_lights[0].inner_angle"},
    {"InfiniteCentre",
     WithLight(PointLight{.position = Vec3(0, std::numeric_limits<float>::infinity(), 0)}),
     kInvalid, "NON_FINITE", "upsert_lights[0].position"},
    {"TooManyTexels", WithReceiver([](Receiver& r) { r.width = r.height = 16384; }),
     absl::StatusCode::kResourceExhausted, "QUOTA_TEXELS", "upsert_receivers[0].width"},
    {"AbsurdSide", WithReceiver([](Receiver& r) { r.height = 0x80000000u; }), kInvalid, "RANGE",
     "upsert_receivers[0].height"},
    {"FlatPatch",
     WithReceiver([](Receiver& r) { std::get<Parallelogram>(r.shape).edge_u = Vec3(0); }), kInvalid,
     "ZERO_AREA", "upsert_receivers[0].edge_u"},
    {"MissingInstance", WithReceiver([](Receiver& r) { r.shape = PlanarInstance{"ghost"}; }),
     absl::StatusCode::kFailedPrecondition, "MISSING_INSTANCE", "upsert_receivers[0].instance_id"},
    {"SolidInstance", WithReceiver([](Receiver& r) { r.shape = PlanarInstance{"a"}; }),
     absl::StatusCode::kFailedPrecondition, "NOT_PLANAR", "upsert_receivers[0].instance_id"},
    {"RemoveUsedInstance", [](SceneDelta& d) { d.remove_instances = {"floor"}; },
     absl::StatusCode::kFailedPrecondition, "MISSING_INSTANCE", "remove_instances[0]"},
    {"BendUsedInstance", [](SceneDelta& d) { d.upsert_instances.push_back(Box("floor")); },
     absl::StatusCode::kFailedPrecondition, "NOT_PLANAR", "upsert_instances[1]"},
};

INSTANTIATE_TEST_SUITE_P(Delta, SceneRefusalTest, ::testing::ValuesIn(kRefusals),
                         [](const auto& refusal) { return refusal.param.what; });

TEST(SceneApply, A10HasLimits) {
  SceneLimits limits;
  limits.max_instances = 3;
  SceneDelta more;
  more.upsert_instances = {Box("one-more")};
  EXPECT_EQ(ErrorReason(Studio()->Apply(more, limits).status()), "QUOTA_INSTANCES");
  limits = {};
  limits.max_triangles_per_scene = 30;
  EXPECT_EQ(ErrorReason(Studio()->Apply(more, limits).status()), "QUOTA_SCENE_TRIANGLES");
  limits = {};
  limits.max_lights = 0;
  SceneDelta light;
  light.upsert_lights = {Lamp("another")};
  EXPECT_EQ(Studio()->Apply(light, limits).status().code(), absl::StatusCode::kResourceExhausted);
}

TEST(SceneApply, A15AcceptsSingularTransforms) {
  SceneDelta delta;
  delta.upsert_instances = {Box("flat"), Box("mirror")};
  delta.upsert_instances[0].world_from_mesh = testing::Placed(Vec3(0), 0);
  delta.upsert_instances[1].world_from_mesh = testing::Placed(Vec3(0), -1);
  EXPECT_TRUE(Studio()->Apply(delta).ok());
}

}  // namespace
}  // namespace penumbra
