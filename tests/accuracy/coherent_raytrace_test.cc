// Coherence-based sampling, over triangles and over depth images, against Embree tracing all
// samples of the same points.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <string>

#include "gtest/gtest.h"
#include "render/light_view/raster_depth_source.h"
#include "render/technique/coherent_raytrace/depth_image_tracer.h"
#include "render/technique/coherent_raytrace/reference_images.h"
#include "render/technique/coherent_raytrace/shadow_field.h"
#include "render/technique/coherent_raytrace/triangle_tracer.h"
#include "tests/accuracy/ledger.h"
#include "tests/support/packet_rays.h"
#include "tests/support/pile_of_things.h"
#include "tests/support/rippled_torus.h"
#include "tests/support/scenes_on_floors.h"

namespace penumbra::testing {
namespace {

constexpr uint32_t kPixels = 256, kSide = 16;

// Root mean squares of what is wrong with attenuation.
struct Worst {
  double triangles = 0, depth_images = 0;
};

class Study {
 public:
  explicit Study(const Scene& scene) : scene_(scene), peer_(scene) {
    Aabb bounds;
    for (const auto& [id, instance] : scene.instances()) {
      if (id != "floor") bounds.Add(WorldBounds(*instance));
    }
    const PicturePixels picture{
        .camera = FrameScene(bounds, 1.0f), .width = kPixels, .height = kPixels};
    points_ = VisiblePoints(*bvhs_.Of(scene, CasterBvhs::Instances::kAll), picture, arena_).value();
  }

  void Compare(const std::string& name, const AreaLight& light, Worst& worst) {
    const float offset = SurfaceOffset(scene_.Bounds());
    const auto truth = peer_.VisibleFrom(
        points_, {.light = light, .side = kSide, .surface_offset = offset}, arena_);
    const double triangles = Rmse(truth, light, TriangleTracer(bvhs_.Flat(scene_), offset));
    RasterDepthSource source(scene_, arena_);
    const auto images = DrawReferenceImages(light, scene_, {}, source, arena_).value();
    const double depth_images = Rmse(truth, light, DepthImageTracer(images, {}));
    const auto partly = std::ranges::count_if(
        truth, [](uint16_t count) { return count > 0 && count < kSide * kSide; });
    std::cout << name << ", " << light.id << ": " << partly << " points in penumbrae, RMSE "
              << triangles << " over triangles, " << depth_images << " over depth images\n";
    EXPECT_GT(partly, 500) << name;
    worst.triangles = std::max(worst.triangles, triangles);
    worst.depth_images = std::max(worst.depth_images, depth_images);
  }

 private:
  double Rmse(const std::vector<uint16_t>& truth, const AreaLight& light,
              const ShadowTracer& tracer) {
    const ShadowFieldSettings settings{.sampling = {.side = kSide, .seed = 1}, .shades = false};
    const auto field = ComputeShadowField(light, points_, tracer, settings, arena_).value();
    double sum2 = 0, count = 0;
    for (size_t i = 0; i < points_.size(); ++i) {
      if (!points_.is_there[i]) continue;
      const double off = (field.visible[i] - truth[i]) / static_cast<double>(kSide * kSide);
      sum2 += off * off, ++count;
    }
    return std::sqrt(sum2 / count);
  }

  const Scene& scene_;
  const PacketRays peer_;
  CasterBvhs bvhs_;
  tbb::task_arena arena_{2};
  SurfacePoints points_;
};

void ExpectKept(const std::string& scenes, const Worst& worst) {
  ExpectInLedger("coherent_raytrace." + scenes + ".triangles_rmse", worst.triangles);
  ExpectInLedger("coherent_raytrace." + scenes + ".depth_images_rmse", worst.depth_images);
}

// The scene's rectangle, and lights of other shapes in its place, as wide.
std::vector<AreaLight> LightsLike(const AreaLight& lamp) {
  const auto& rectangle = std::get<RectangleLight>(lamp.shape);
  const Vec3 middle = rectangle.corner + 0.5f * (rectangle.edge_u + rectangle.edge_v);
  const float radius = 0.5f * glm::length(rectangle.edge_u);
  return {lamp,
          {.id = "disk",
           .shape = DiskLight{.center = middle, .normal = {0.2f, -1, 0}, .radius = radius}},
          {.id = "ball", .shape = SphereLight{.center = middle, .radius = radius}},
          {.id = "sun",
           .shape = DistantLight{.to_light = glm::normalize(Vec3(0.5f, 1, 0.2f)),
                                 .angular_diameter = 0.2f}}};
}

TEST(CoherentRaytraceAccuracyTest, ScenesOfOurOwnAgreeWithRays) {
  Worst worst;
  const std::pair<std::string, std::vector<Instance>> scenes[] = {
      {"torus", {{.id = "torus", .mesh = MeshOf(RippledTorus(160, 64))}}},
      {"pile", PileOfThings()}};
  for (const auto& [name, instances] : scenes) {
    const auto scene = OnFloor(instances);
    Study study(*scene);
    for (const AreaLight& light : LightsLike(*scene->FindLight("lamp"))) {
      study.Compare(name, light, worst);
    }
  }
  ExpectKept("own", worst);
}

TEST(CoherentRaytraceAccuracyTest, ScenesOfOtherAuthorsAgreeWithRays) {
  const auto folder = ScenesFolder(PENUMBRA_DEFAULT_SCENES);
  if (!std::filesystem::exists(folder)) {
    GTEST_SKIP() << folder << " is not there; PENUMBRA_SCENES names a folder of scenes";
  }
  Worst worst;
  for (const SceneFile& file : kScenesOnFloors) {
    const auto scene = LoadOnFloor(folder / file.path);
    ASSERT_TRUE(scene.ok()) << file.name << ": " << scene.status();
    Study(**scene).Compare(file.name, *(*scene)->FindLight("lamp"), worst);
  }
  ExpectKept("scenes", worst);
}

}  // namespace
}  // namespace penumbra::testing
