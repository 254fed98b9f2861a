// Hierarchies that techniques find again: after an edit, and for another light.
#include "render/technique/kept_bvhs.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "tests/support/shapes.h"

namespace penumbra::testing {
namespace {

SceneDelta BoxAt(float x) {
  return {.upsert_instances = {{.id = "box",
                                .mesh = MeshOf(UnitBoxGeometry()),
                                .world_from_mesh = Placed(Vec3(x, 1, 0), 0.3f)}}};
}

// The box and a ground under two lamps.
std::shared_ptr<const Scene> Studio() {
  SceneDelta delta = BoxAt(0);
  delta.upsert_instances.push_back({.id = "ground",
                                    .mesh = MeshOf(UnitSquareGeometry()),
                                    .world_from_mesh = Placed(Vec3(0), Vec3(2, 1, 2))});
  for (const char* id : {"left", "right"}) {
    const float x = *id == 'l' ? -2.0f : 1.0f;
    delta.upsert_lights.push_back(
        {.id = id,
         .shape = RectangleLight{
             .corner = Vec3(x, 3, 0), .edge_u = Vec3(1, 0, 0), .edge_v = Vec3(0, 0, 1)}});
  }
  return Scene::Empty("s")->Apply(delta).value();
}

class KeptBvhsTest : public ::testing::Test {
 protected:
  // How many hierarchies are built to compute it.
  size_t BuiltFor(const Scene& scene, const ArtifactSpec& spec, TechniqueMemory& memory) {
    const ComputeContext context{.arena = arena_, .memory = &memory};
    const size_t before = KeptBvhs(context).built();
    const auto artifact = TechniqueFor(spec.params).Compute(scene, spec, context);
    EXPECT_TRUE(artifact.ok()) << artifact.status();
    return KeptBvhs(context).built() - before;
  }

  TechniqueMemory NewMemory() { return {.budget = budget_, .of_scene = of_scene_}; }

  tbb::task_arena arena_{2};
  MemoryBudget budget_{1 << 20};
  const std::shared_ptr<SceneMemory> of_scene_ = std::make_shared<SceneMemory>();
  const std::shared_ptr<const Scene> before_ = Studio();
  const std::shared_ptr<const Scene> after_ = before_->Apply(BoxAt(0.5f)).value();
};

TEST_F(KeptBvhsTest, PicturesBuildWhatMovedAndWhatIsOverAll) {
  ArtifactSpec left{CoherentRaytraceParams{.samples = 4}, "left"};
  left.points = PicturePixels{
      .camera = {.eye = {2, 3, 3}, .target = {0, 0.3f, 0}}, .width = 16, .height = 16};
  ArtifactSpec right = left;
  right.light_id = "right";
  TechniqueMemory of_left = NewMemory(), of_right = NewMemory();
  EXPECT_EQ(BuiltFor(*before_, left, of_left), 3u) << "the box, the ground, one over all triangles";
  EXPECT_EQ(BuiltFor(*before_, right, of_right), 0u);
  EXPECT_EQ(BuiltFor(*after_, left, of_left), 2u) << "the ground is there still";
  EXPECT_EQ(BuiltFor(*after_, right, of_right), 0u);
}

TEST_F(KeptBvhsTest, LayersBuildWhatMoved) {
  const LayeredAttenuationParams params{
      .samples = 4, .resolution = 32, .source = DepthMethod::kRays};
  const ArtifactSpec left{params, "left"}, right{params, "right"};
  TechniqueMemory of_left = NewMemory(), of_right = NewMemory();
  EXPECT_EQ(BuiltFor(*before_, left, of_left), 2u);
  EXPECT_EQ(BuiltFor(*before_, right, of_right), 0u);
  EXPECT_EQ(BuiltFor(*after_, left, of_left), 1u);
  EXPECT_EQ(BuiltFor(*after_, right, of_right), 0u);
}

TEST_F(KeptBvhsTest, GoWithTheLastArtifactThatKeepsThem) {
  const ArtifactSpec spec{
      LayeredAttenuationParams{.samples = 4, .resolution = 32, .source = DepthMethod::kRays},
      "left"};
  {
    TechniqueMemory memory = NewMemory();
    BuiltFor(*before_, spec, memory);
    EXPECT_FALSE(budget_.Take(1 << 20));
  }
  EXPECT_TRUE(budget_.Take(1 << 20));
  TechniqueMemory again = NewMemory();
  EXPECT_EQ(BuiltFor(*before_, spec, again), 2u);
}

}  // namespace
}  // namespace penumbra::testing
