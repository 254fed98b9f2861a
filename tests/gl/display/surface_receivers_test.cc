// Pictures of receivers that do not fill their patch, and of instances with a receiver a face.
#include <gtest/gtest.h>

#include "tests/gl/display/small_scenes.h"
#include "tests/gl/display/thin_renderer_fixture.h"

namespace penumbra {
namespace {

constexpr Vec3 kLampPosition(0, 8, 0);

std::shared_ptr<const Artifact> WithMask(const Scene& scene, const std::string& receiver_id,
                                         std::shared_ptr<const Artifact> artifact) {
  auto masked = std::make_shared<Artifact>(*artifact);
  auto& texture = std::get<SoftShadowTexture>(masked->payload);
  const auto patch = scene.ResolveReceiver(receiver_id);
  texture.coverage = CoverRegion(*patch->region, patch->width, patch->height);
  return masked;
}

class SurfaceReceiversTest : public ThinRendererTest {
 protected:
  Picture Draw(const Scene& scene, std::vector<std::shared_ptr<const Artifact>> artifacts,
               const Camera& camera, const RenderOptions& options) {
    const auto picture = renderer_->Render(*context_, scene, artifacts, camera, options);
    EXPECT_TRUE(picture.ok()) << picture.status();
    return picture.ok() ? *picture
                        : Picture{.width = 64, .height = 64, .pixels = std::vector<Vec4>(64 * 64)};
  }
  double BrightnessAt(const Picture& picture, const Camera& camera, Vec3 wanted, Vec3 normal) {
    double nearest = 1e9, brightness = -1;
    for (int y = 0; y < picture.height; ++y) {
      for (int x = 0; x < picture.width; ++x) {
        const Vec3 hit = HitPlane(camera, picture, x, y, wanted, normal);
        const double off = glm::length(hit - wanted);
        if (off >= nearest) continue;
        nearest = off;
        brightness = picture.At(x, y).x;
      }
    }
    return brightness;
  }
};

// An L in the dark next to nothing: drawn where it is, and only there.
TEST_F(SurfaceReceiversTest, APolygonIsDrawnAsFarAsItGoes) {
  const auto scene = SceneOf(
      {.upsert_lights = {{.id = "l", .shape = PointLight{kLampPosition, Vec3(1000)}}},
       .upsert_receivers = {
           {.id = "r",
            .shape =
                PlanarPolygon{{{0, 0, 0}, {0, 0, 2}, {1, 0, 2}, {1, 0, 1}, {2, 0, 1}, {2, 0, 0}}},
            .width = 16,
            .height = 16}}});
  const auto lit =
      WithMask(*scene, "r", ArtifactOf(*scene, "l", "r", 4, [](auto, auto) { return 4u; }));
  const Camera camera{.eye = {1, 5, 1.01f}, .target = {1, 0, 1}, .up = {0, 0, -1}};
  const auto picture = Draw(*scene, {lit}, camera, {.width = 64, .height = 64});
  const Vec3 up(0, 1, 0);
  for (const Vec3 inside : {Vec3(0.1f, 0, 0.1f), Vec3(0.1f, 0, 1.9f), Vec3(1.9f, 0, 0.1f),
                            Vec3(0.9f, 0, 0.9f), Vec3(0.9f, 0, 1.1f)}) {
    EXPECT_GT(BrightnessAt(picture, camera, inside, up), 0.1) << inside.x << " " << inside.z;
  }
  for (const Vec3 outside : {Vec3(1.1f, 0, 1.1f), Vec3(1.9f, 0, 1.9f), Vec3(1.2f, 0, 1.8f)}) {
    EXPECT_EQ(BrightnessAt(picture, camera, outside, up), 0) << outside.x << " " << outside.z;
  }
}

// Two halves of one square belong to two receivers, one dark and one lit, whose patches overlap:
// each half must be found in its own.
TEST_F(SurfaceReceiversTest, EachFaceFindsTheReceiverThatCoversIt) {
  const auto scene = SceneOf(
      {.upsert_instances = {{.id = "floor", .mesh = Quad({0, 0, 2}, {2, 0, 0}, {0, 0, -2})}},
       .upsert_lights = {{.id = "l", .shape = PointLight{kLampPosition, Vec3(1000)}}},
       .upsert_receivers = {
           {.id = "dark",
            .shape = PlanarPolygon{{{0, 0, 2}, {2, 0, 2}, {2, 0, 1}, {1, 0, 0.9f}, {0, 0, 0}}},
            .width = 32,
            .height = 32},
           {.id = "lit",
            .shape = PlanarPolygon{{{0, 0, 0}, {1, 0, 0.9f}, {2, 0, 1}, {2, 0, 0}}},
            .width = 32,
            .height = 32}}});
  const auto dark =
      WithMask(*scene, "dark", ArtifactOf(*scene, "l", "dark", 4, [](auto, auto) { return 0u; }));
  const auto lit =
      WithMask(*scene, "lit", ArtifactOf(*scene, "l", "lit", 4, [](auto, auto) { return 4u; }));
  const Camera camera{.eye = {1, 5, 1.01f}, .target = {1, 0, 1}, .up = {0, 0, -1}};
  const auto picture = Draw(*scene, {dark, lit}, camera, {.width = 64, .height = 64});
  const Vec3 up(0, 1, 0);
  for (const Vec3 p : {Vec3(0.2f, 0, 1.8f), Vec3(1.8f, 0, 1.2f), Vec3(1, 0, 1.2f)}) {
    EXPECT_EQ(BrightnessAt(picture, camera, p, up), 0) << p.x << " " << p.z;
  }
  for (const Vec3 p : {Vec3(1.8f, 0, 0.1f), Vec3(1, 0, 0.5f), Vec3(1.7f, 0, 0.7f)}) {
    EXPECT_GT(BrightnessAt(picture, camera, p, up), 0.1) << p.x << " " << p.z;
  }
}

// A room that is dark in all its corners, hundreds of units wide, with the eye near a wall: many
// triangles are clipped, and those which share a pixel must each find their receiver.
TEST_F(SurfaceReceiversTest, NoSeamOfADarkRoomIsLit) {
  SceneDelta delta{
      .upsert_instances = {{.id = "room", .mesh = Cuboid({0, 0, 0}, {556, 549, 559})},
                           {.id = "block", .mesh = Cuboid({265, 0, 247}, {472, 330, 456})}},
      .upsert_lights = {{.id = "l", .shape = PointLight{{278, 548, 279}, Vec3(1e6f)}}}};
  for (const char* id : {"room", "block"}) {
    for (uint32_t side = 0; side < 6; ++side) {
      delta.upsert_receivers.push_back({.id = id + std::to_string(side),
                                        .shape = PlanarSurface{id, 2 * side},
                                        .width = 16,
                                        .height = 16});
    }
  }
  const auto scene = SceneOf(delta);
  std::vector<std::shared_ptr<const Artifact>> dark;
  for (const auto& [id, receiver] : scene->receivers()) {
    dark.push_back(ArtifactOf(*scene, "l", id, 4, [](auto, auto) { return 0u; }));
  }
  for (const Vec3 eye : {Vec3(100, 200, 100), Vec3(30, 500, 400), Vec3(278, 273, 5)}) {
    const Camera camera{.eye = eye, .target = {300, 150, 330}, .fov_y_deg = 70};
    const auto picture =
        Draw(*scene, dark, camera, {.width = 300, .height = 200, .draws_lights = false});
    size_t lit = 0;
    for (const Vec4& pixel : picture.pixels) lit += pixel.x > 0;
    EXPECT_EQ(lit, 0u) << eye.x;
  }
}

}  // namespace
}  // namespace penumbra
