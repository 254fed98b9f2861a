// Row A19 of the catalogue: as many triangles as loops of shaders may not have turns (llvmpipe ends
// them at 65,535), by GL and by the CPU.
#include <gtest/gtest.h>

#include <cstdlib>

#include "render/light_view/gl_depth_source.h"
#include "render/light_view/raster_depth_source.h"
#include "render/light_view/view_fit.h"
#include "render/technique/technique.h"
#include "tests/gl/display/software_context.h"
#include "tests/gl/engine/gl_specs.h"
#include "tests/support/random_scene.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {
namespace {

// Crumbs over the floor, one triangle each, the last of which alone casts a large shadow: who
// leaves out the end of them is found out.
SceneDelta CrumbsOverFloor(size_t triangles) {
  Dice dice(7);
  MeshGeometry crumbs;
  for (size_t t = 0; t < triangles; ++t) {
    const float size = t + 1 == triangles ? 0.8f : 0.004f;
    const Vec3 at = t + 1 == triangles ? Vec3(-0.4f, 0.5f, -0.4f)
                                       : 1.5f * Vec3(dice.Between(-1, 1), 0, dice.Between(-1, 1)) +
                                             Vec3(0, dice.Between(0.1f, 1), 0);
    const auto first = static_cast<uint32_t>(crumbs.positions.size());
    crumbs.positions.insert(crumbs.positions.end(),
                            {at, at + Vec3(size, 0, 0), at + Vec3(0, 0.1f * size, size)});
    crumbs.indices.insert(crumbs.indices.end(), {first, first + 1, first + 2});
  }
  SceneDelta delta = BallOverFloor(64);
  delta.upsert_instances = {{.id = "crumbs", .mesh = MeshOf(std::move(crumbs))}};
  return delta;
}

class ManyTrianglesTest : public SoftwareContextTest, public ::testing::WithParamInterface<size_t> {
 protected:
  void SetUp() override {
    SoftwareContextTest::SetUp();
    scene_ = Scene::Empty("s")->Apply(CrumbsOverFloor(GetParam())).value();
  }
  Artifact Compute(const ArtifactSpec& spec) {
    return TechniqueFor(spec.params)
        .Compute(*scene_, spec, {.arena = arena_, .gl = context_.get()})
        .value();
  }

  tbb::task_arena arena_{2};
  std::shared_ptr<const Scene> scene_;
};

TEST_P(ManyTrianglesTest, A19TexturesCountThemAll) {
  const GlSpec texture = GlSpecs(64, 16).front();
  const Artifact by_gl = Compute(texture.spec), by_cpu = Compute(texture.by_cpu);
  const auto& counts = std::get<SoftShadowTexture>(by_gl.payload).visibility.counts;
  const auto& others = std::get<SoftShadowTexture>(by_cpu.payload).visibility.counts;
  size_t differing = 0, hidden = 0;
  for (size_t t = 0; t < counts.size(); ++t) {
    differing += static_cast<size_t>(std::abs(counts[t] - others[t]));
    hidden += 16u - counts[t];
  }
  EXPECT_LE(differing, counts.size() * 16 / 10'000);
  EXPECT_GT(hidden, counts.size() * 16 / 20) << "the last triangle's alone";
}

TEST_P(ManyTrianglesTest, A19DepthMapsSeeThemAll) {
  for (const GlSpec& spec : GlSpecs(64, 4)) {
    if (spec.name != "shadow_width") continue;
    const Artifact by_gl = Compute(spec.spec), by_cpu = Compute(spec.by_cpu);
    const auto& depths = std::get<ShadowWidthMap>(by_gl.payload).faces.front().near.depths;
    const auto& others = std::get<ShadowWidthMap>(by_cpu.payload).faces.front().near.depths;
    ASSERT_EQ(depths.size(), others.size());
    size_t differing = 0, seen = 0;
    for (size_t t = 0; t < depths.size(); ++t) {
      const bool is_same =
          depths[t] == others[t] || std::abs(depths[t] - others[t]) <= 1e-5f * others[t];
      differing += !is_same;
      seen += depths[t] != kNoDepth;
    }
    EXPECT_LE(differing, depths.size() / 1000);
    EXPECT_GT(seen, depths.size() / 100);
  }
}

INSTANTIATE_TEST_SUITE_P(Counts, ManyTrianglesTest,
                         ::testing::Values(65'535, 65'536, 65'537, 100'000));

}  // namespace
}  // namespace penumbra::testing
