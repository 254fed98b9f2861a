#include "client/cli/point_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "client/cli/command_line.h"
#include "client/cli/shadow_plan.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

using ::testing::ElementsAre;

ImportedScene SmallScene() {
  MeshGeometry triangle{.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, .indices = {0, 1, 2}};
  ImportedScene scene;
  scene.instances.push_back({.id = "sail", .mesh = Mesh::Create(triangle).value()});
  scene.lights.push_back({.id = "lamp", .shape = SphereLight{.center = {0, 5, 0}}});
  scene.lights.push_back({.id = "sun", .shape = DistantLight{}});
  return scene;
}

ShadowRequest RequestFor(TechniqueParams params) {
  ShadowRequest request;
  request.params = params;
  return request;
}

std::vector<std::string> NamesOf(const ShadowPlan& plan, const TechniqueParams& params) {
  std::vector<std::string> names;
  for (const PlannedShadow& shadow : ShadowsOf(plan, params)) names.push_back(shadow.name);
  return names;
}

TEST(PointPlan, APictureIsComputedWhereNothingIsNamed) {
  const ShadowRequest request = RequestFor(CoherentRaytraceParams{});
  const auto plan = PlanShadows(SmallScene(), request);
  ASSERT_TRUE(plan.ok()) << plan.status();
  EXPECT_THAT(NamesOf(*plan, request.params), ElementsAre("picture.lamp", "picture.sun"));
  const auto& picture = std::get<PicturePixels>(plan->points.front().receiver);
  EXPECT_EQ(picture.width, 512u);
  EXPECT_TRUE(CheckTarget(ShadowsOf(*plan, request.params)[0].spec).ok());
}

TEST(PointPlan, LightmapsAndPointsAreComputedInItsPlace) {
  ShadowRequest request = RequestFor(CoherentRaytraceParams{});
  const std::string path = testing::TempDir() + "/penumbra_points.txt";
  std::ofstream(path) << "# probes\n0 1 0  0 1 0\n\n1,1,0, 0,0,2  # tilted\n";
  request.points.lightmaps = {"sail"};
  request.points.file = path;
  const auto plan = PlanShadows(SmallScene(), request);
  ASSERT_TRUE(plan.ok()) << plan.status();
  EXPECT_THAT(NamesOf(*plan, request.params),
              ElementsAre("sail.lamp", "sail.sun", "points.lamp", "points.sun"));
  const auto& given = std::get<GivenPoints>(plan->points.back().receiver);
  ASSERT_EQ(given.size(), 2u);
  EXPECT_EQ((*given.points)[1].normal, Vec3(0, 0, 2));
  // A camera asks for a picture besides.
  request.points.camera = Camera{};
  EXPECT_EQ(PlanShadows(SmallScene(), request)->points.size(), 3u);
}

TEST(PointPlan, TheFloorIsAnInstanceForAllSurfaces) {
  ShadowRequest request = RequestFor(LayeredAttenuationParams{});
  request.floor = true;
  const auto plan = PlanShadows(SmallScene(), request);
  ASSERT_TRUE(plan.ok()) << plan.status();
  EXPECT_TRUE(plan->delta.upsert_receivers.empty());
  ASSERT_EQ(plan->delta.upsert_instances.size(), 2u);
  EXPECT_EQ(plan->delta.upsert_instances.back().id, "floor");
  EXPECT_THAT(NamesOf(*plan, request.params), ElementsAre("lamp", "sun"));
}

TEST(PointPlan, SaysWhatIsWrong) {
  const auto fault = [](auto change, TechniqueParams params) {
    ShadowRequest request = RequestFor(params);
    change(request);
    const absl::Status status = PlanShadows(SmallScene(), request).status();
    return ErrorFieldPath(status) + " " + ErrorReason(status);
  };
  const CoherentRaytraceParams coherent;
  EXPECT_EQ(fault([](auto& r) { r.points.lightmaps = {"tent"}; }, coherent),
            "--lightmap UNKNOWN_ID");
  EXPECT_EQ(fault([](auto& r) { r.points.crop = {600, 0, 10, 10}; }, coherent), "--picture RANGE");
  const std::string path = testing::TempDir() + "/penumbra_bad_points.txt";
  std::ofstream(path) << "0 1 0  0 1 0\n0 1 0\n";
  EXPECT_EQ(ErrorReason(ReadPoints(path).status()), "NUMBER_COUNT");
  EXPECT_THAT(std::string(ReadPoints(path).status().message()), testing::HasSubstr(":2: found 3"));
  std::ofstream(path) << "0 1 0  0 0 0\n";
  EXPECT_EQ(ErrorReason(ReadPoints(path).status()), "RANGE");
  EXPECT_TRUE(absl::IsNotFound(ReadPoints(testing::TempDir() + "/nowhere").status()));
}

}  // namespace
}  // namespace penumbra
