// What bad deltas get: the right code, a stable reason and the field; the scene as it was, other
// clients undisturbed, and the session still good. The name of each begins with its row.

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <string>

#include "proto/convert/geometry_convert.h"
#include "proto/convert/light_convert.h"
#include "proto/convert/scene_convert.h"
#include "tests/integration/catalogue/catalogue_test.h"

namespace penumbra::testing {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;
constexpr auto kNotFound = absl::StatusCode::kNotFound;
constexpr auto kFailedPrecondition = absl::StatusCode::kFailedPrecondition;

struct RefusedDelta {
  const char* name;
  std::function<void(v1::SceneDelta&)> write;
  Refusal refusal;
};

// Each brings one sound object, spoilt.
auto WithBox(std::function<void(v1::Instance&)> spoil) {
  return [spoil](v1::SceneDelta& delta) {
    *delta.add_upsert_instances() = ToProto(Box({1, 1, 1}, "another"));
    spoil(*delta.mutable_upsert_instances(0));
  };
}
auto WithLight(std::function<void(v1::Light&)> spoil) {
  return [spoil](v1::SceneDelta& delta) {
    *delta.add_upsert_lights() = ToProto(SquareLight());
    spoil(*delta.mutable_upsert_lights(0));
  };
}
auto WithReceiver(std::function<void(v1::Receiver&)> spoil) {
  return [spoil](v1::SceneDelta& delta) {
    *delta.add_upsert_receivers() = ToProto(FloorReceiver("another", 2, 8));
    spoil(*delta.mutable_upsert_receivers(0));
  };
}

const RefusedDelta kRefusedDeltas[] = {
    {"A01NanInATransform",
     WithBox([](auto& box) { box.set_world_from_mesh(9, kNan); }),
     {kInvalid, "NON_FINITE", "upsert_instances[0].world_from_mesh"}},
    {"A01NanInAColour",
     WithBox([](auto& box) { box.mutable_color()->set_y(kNan); }),
     {kInvalid, "NON_FINITE", "upsert_instances[0].color"}},
    {"A01NanAsACutoff",
     WithBox([](auto& box) { box.set_alpha_cutoff(kNan); }),
     {kInvalid, "NON_FINITE", "upsert_instances[0].alpha_cutoff"}},
    {"A01InfiniteCorner",
     WithLight([](auto& lamp) { lamp.mutable_rectangle()->mutable_corner()->set_y(kInfinity); }),
     {kInvalid, "NON_FINITE", "upsert_lights[0].corner"}},
    {"A01MinusInfinityAsARadius",
     WithLight([](auto& lamp) { lamp.mutable_sphere()->set_radius(-kInfinity); }),
     {kInvalid, "NON_FINITE", "upsert_lights[0].radius"}},
    {"A01NanInAReceiver",
     WithReceiver(
         [](auto& floor) { floor.mutable_parallelogram()->mutable_edge_u()->set_x(kNan); }),
     {kInvalid, "NON_FINITE", "upsert_receivers[0].edge_u"}},
    {"A02InstanceFarAway",
     WithBox([](auto& box) { box.set_world_from_mesh(9, 1e16f); }),
     {kInvalid, "OUT_OF_BOUNDS", "upsert_instances[0].world_from_mesh"}},
    {"A02LightFarAway",
     WithLight([](auto& lamp) { lamp.mutable_point()->mutable_position()->set_z(-1e15f); }),
     {kInvalid, "OUT_OF_BOUNDS", "upsert_lights[0].position"}},
    {"A02ScaleWhoseSquareOverflows",
     WithBox([](auto& box) { box.set_world_from_mesh(0, 1e30f); }),
     {kInvalid, "OUT_OF_BOUNDS", "upsert_instances[0].world_from_mesh"}},
    {"A12RectangleOfNoWidth",
     WithLight([](auto& lamp) { lamp.mutable_rectangle()->mutable_edge_u()->Clear(); }),
     {kInvalid, "ZERO_AREA", "upsert_lights[0].edge_u"}},
    {"A12RectangleOfParallelEdges",
     WithLight([](auto& lamp) {
       *lamp.mutable_rectangle()->mutable_edge_v() = lamp.rectangle().edge_u();
     }),
     {kInvalid, "ZERO_AREA", "upsert_lights[0].edge_v"}},
    {"A12DiskOfNoRadius",
     WithLight([](auto& lamp) { lamp.mutable_disk()->set_radius(0); }),
     {kInvalid, "ZERO_AREA", "upsert_lights[0].radius"}},
    {"A12SphereOfNoRadius",
     WithLight([](auto& lamp) { lamp.mutable_sphere()->set_radius(0); }),
     {kInvalid, "ZERO_AREA", "upsert_lights[0].radius"}},
    {"A13NegativeRadius",
     WithLight([](auto& lamp) { lamp.mutable_sphere()->set_radius(-1); }),
     {kInvalid, "ZERO_AREA", "upsert_lights[0].radius"}},
    {"A13NanIntensity",
     WithLight([](auto& lamp) { lamp.mutable_point()->mutable_intensity()->set_x(kNan); }),
     {kInvalid, "NON_FINITE", "upsert_lights[0].intensity"}},
    {"A13NegativeRadiance",
     WithLight([](auto& lamp) { lamp.mutable_rectangle()->mutable_radiance()->set_x(-1); }),
     {kInvalid, "RANGE", "upsert_lights[0].radiance"}},
    {"A13NormalOfNoLength",
     WithLight([](auto& lamp) { lamp.mutable_disk()->mutable_normal()->Clear(); }),
     {kInvalid, "ZERO_LENGTH", "upsert_lights[0].normal"}},
    {"A13ReceiverOfNoArea",
     WithReceiver([](auto& floor) {
       *floor.mutable_parallelogram()->mutable_edge_v() = floor.parallelogram().edge_u();
     }),
     {kInvalid, "ZERO_AREA", "upsert_receivers[0].edge_v"}},
    {"A16ElevenNumbers",
     WithBox([](auto& box) { box.mutable_world_from_mesh()->RemoveLast(); }),
     {kInvalid, "LENGTH", "upsert_instances[0].world_from_mesh"}},
    {"A16SixteenNumbersWithALastRow",
     WithBox([](auto& box) {
       for (const float x : {0.0f, 0.0f, 0.5f, 1.0f}) box.add_world_from_mesh(x);
     }),
     {kInvalid, "LENGTH", "upsert_instances[0].world_from_mesh"}},
    {"A16QuaternionInPlaceOfAMatrix",
     WithBox([](auto& box) { box.mutable_world_from_mesh()->Resize(4, 0.0f); }),
     {kInvalid, "LENGTH", "upsert_instances[0].world_from_mesh"}},
    {"A20ReceiverOf16385Texels",
     WithReceiver([](auto& floor) { floor.set_height(16385); }),
     {kInvalid, "RANGE", "upsert_receivers[0].height"}},
    {"A20ReceiverOfTwoToThe31",
     WithReceiver([](auto& floor) { floor.set_width(0x80000000u); }),
     {kInvalid, "RANGE", "upsert_receivers[0].width"}},
    {"A20ReceiverOfTooManyTexels",
     WithReceiver([](auto& floor) {
       floor.set_width(16384);
       floor.set_height(16384);
     }),
     {absl::StatusCode::kResourceExhausted, "QUOTA_TEXELS", "upsert_receivers[0].width"}},
    {"B04RemovalOfAnUnknownInstance",
     [](v1::SceneDelta& delta) { delta.add_remove_instances("ghost"); },
     {kNotFound, "UNKNOWN_ID", "remove_instances[0]"}},
    {"B04RemovalOfAnUnknownLight",
     [](v1::SceneDelta& delta) {
       delta.add_remove_lights("lamp");
       delta.add_remove_lights("Lamp");
     },
     {kNotFound, "UNKNOWN_ID", "remove_lights[1]"}},
    {"B05MissingMesh",
     WithBox([](auto& box) { box.set_mesh_hash(std::string(32, 'x')); }),
     {kFailedPrecondition, "MISSING_BLOB", "upsert_instances[0].mesh_hash"}},
    {"B05MissingMask",
     WithBox([](auto& box) { box.set_alpha_mask_hash(std::string(32, 'x')); }),
     {kFailedPrecondition, "MISSING_BLOB", "upsert_instances[0].alpha_mask_hash"}},
    {"B05ReceiverOnAMissingInstance",
     WithReceiver([](auto& floor) { floor.mutable_planar_instance()->set_instance_id("ghost"); }),
     {kFailedPrecondition, "MISSING_INSTANCE", "upsert_receivers[0].instance_id"}},
    {"ShortHash",
     WithBox([](auto& box) { box.set_mesh_hash("short"); }),
     {kInvalid, "LENGTH", "upsert_instances[0].mesh_hash"}},
    {"B06BehindTheHead",
     [](v1::SceneDelta& delta) { delta.set_base_revision(0); },
     {absl::StatusCode::kAborted, "STALE_BASE", "base_revision"}},
    {"B07AheadOfTheHead",
     [](v1::SceneDelta& delta) { delta.set_base_revision(2); },
     {absl::StatusCode::kOutOfRange, "FUTURE_BASE", "base_revision"}},
    {"B07TheLastRevisionThatThereIs",
     [](v1::SceneDelta& delta) { delta.set_base_revision(std::numeric_limits<int64_t>::max()); },
     {absl::StatusCode::kOutOfRange, "FUTURE_BASE", "base_revision"}},
    // What a client that counts with signs sends for −1.
    {"B07Negative",
     [](v1::SceneDelta& delta) { delta.set_base_revision(~uint64_t{0}); },
     {absl::StatusCode::kOutOfRange, "FUTURE_BASE", "base_revision"}},
    {"B12GoodFirstBadLast",
     [](v1::SceneDelta& delta) {
       *delta.add_upsert_instances() = ToProto(Box({1, 1, 1}, "another"));
       delta.add_remove_lights("lamp");
       delta.add_remove_receivers("ghost");
     },
     {kNotFound, "UNKNOWN_ID", "remove_receivers[0]"}},
    {"B12OneIdTwice",
     [](v1::SceneDelta& delta) {
       *delta.add_upsert_instances() = ToProto(Box({1, 1, 1}, "another"));
       *delta.add_upsert_instances() = ToProto(Box({2, 1, 1}, "another"));
     },
     {kInvalid, "DUPLICATE_ID", "upsert_instances[1].id"}},
    {"B12RemovedAndPlacedAtOnce",
     [](v1::SceneDelta& delta) {
       *delta.add_upsert_lights() = ToProto(SquareLight());
       delta.add_remove_lights("lamp");
     },
     {kInvalid, "DUPLICATE_ID", "upsert_lights[0].id"}},
    {"B15LightWithoutShape",
     [](v1::SceneDelta& delta) { delta.add_upsert_lights()->set_id("l"); },
     {kInvalid, "MISSING_FIELD", "upsert_lights[0].shape"}},
    {"B15ReceiverWithoutShape",
     [](v1::SceneDelta& delta) { delta.add_upsert_receivers()->set_id("r"); },
     {kInvalid, "MISSING_FIELD", "upsert_receivers[0].shape"}},
};

class RefusedDeltaTest : public CatalogueTest,
                         public ::testing::WithParamInterface<RefusedDelta> {};

TEST_P(RefusedDeltaTest, LeavesEverythingAsItWas) {
  v1::SceneDelta delta;
  GetParam().write(delta);
  ExpectRefused(delta, GetParam().refusal);
}

INSTANTIATE_TEST_SUITE_P(All, RefusedDeltaTest, ::testing::ValuesIn(kRefusedDeltas),
                         [](const auto& row) { return row.param.name; });

}  // namespace
}  // namespace penumbra::testing
