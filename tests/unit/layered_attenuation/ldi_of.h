// Attenuation LDIs of small scenes.
//
//   const auto scene = SceneOf({{.id = "floor", .mesh = …}});
//   const AttenuationLdi ldi = LdiOf(*scene, light);
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <vector>

#include "render/light_view/raster_depth_source.h"
#include "render/technique/layered_attenuation/ldi_passes.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {

inline std::shared_ptr<const Scene> SceneOf(std::vector<Instance> instances) {
  SceneDelta delta;
  for (size_t i = 0; i < instances.size(); ++i) instances[i].id = std::to_string(i);
  delta.upsert_instances = std::move(instances);
  return Scene::Empty("s")->Apply(delta).value();
}

inline Instance Placed(MeshGeometry geometry, const Affine& world_from_mesh = IdentityAffine()) {
  return {.mesh = MeshOf(std::move(geometry)), .world_from_mesh = world_from_mesh};
}

// `half.x` by `half.z` metres to each side of `center`, facing up.
inline Instance Sheet(Vec3 center, float half_x, float half_z) {
  return Placed(UnitSquareGeometry(), Placed(center, Vec3(half_x, 1, half_z)));
}

inline AttenuationLdi LdiOf(const Scene& scene, const AreaLight& light,
                            const LdiOptions& options = {.samples = 256, .resolution = 256},
                            int threads = 2) {
  tbb::task_arena arena(threads);
  RasterDepthSource source(scene, arena);
  const auto passes = LdiPasses::Create(scene, light, options, source, arena);
  EXPECT_TRUE(passes.ok()) << passes.status();
  const absl::Status status = (*passes)->Advance((*passes)->sample_count(), {});
  EXPECT_TRUE(status.ok()) << status;
  return (*passes)->Finish();
}

// How far what an LDI says is from what should be.
class Deviation {
 public:
  void Add(double found, double expected) {
    const double off = std::abs(found - expected);
    sum_ += off;
    bias_ += found - expected;
    most_ = std::max(most_, off);
    partly_ += expected > 0.05 && expected < 0.95;
    ++count_;
  }

  double mean() const { return sum_ / static_cast<double>(count_); }
  double bias() const { return bias_ / static_cast<double>(count_); }
  double most() const { return most_; }
  int count() const { return count_; }
  int partly_lit() const { return partly_; }  // points expected to be

 private:
  double sum_ = 0, bias_ = 0, most_ = 0;
  int count_ = 0, partly_ = 0;
};

}  // namespace penumbra::testing
