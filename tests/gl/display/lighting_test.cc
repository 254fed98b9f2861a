// What the thin renderer makes of lights and artifacts, pixel by pixel against closed forms.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "client/display/thin_renderer.h"
#include "render/scene/unoccluded_light.h"
#include "tests/gl/display/small_scenes.h"
#include "tests/gl/display/software_context.h"

namespace penumbra {
namespace {

const Camera kAbove = {.eye = {0.4f, 5, 3}, .target = {0, 0, 0}, .up = {0, 1, 0}, .fov_y_deg = 25};
const Vec3 kFloorColor(0.8f, 0.5f, 0.25f);
const Vec3 kAmbient(0.01f, 0.02f, 0.03f);
const RenderOptions kSmall = {
    .width = 96, .height = 64, .samples_per_side = 1, .ambient = kAmbient, .draws_lights = false};

Instance Floor() {
  return {.id = "floor", .mesh = Quad({-4, 0, 4}, {8, 0, 0}, {0, 0, -8}), .color = kFloorColor};
}

AreaLight Lamp() {
  return {.id = "lamp",
          .shape = RectangleLight{.corner = {-0.5f, 1.5f, 0.2f},
                                  .edge_u = {1, 0.2f, 0},
                                  .edge_v = {0, 0.1f, 0.7f},
                                  .radiance = {3, 2, 1}}};
}

class LightingTest : public SoftwareContextTest {
 protected:
  void SetUp() override {
    SoftwareContextTest::SetUp();
    auto renderer = ThinRenderer::Create(*context_);
    ASSERT_TRUE(renderer.ok()) << renderer.status();
    renderer_ = *std::move(renderer);
  }

  Picture Render(const Scene& scene, const std::vector<std::shared_ptr<const Artifact>>& artifacts,
                 const RenderOptions& options = kSmall, const Camera& camera = kAbove) {
    auto picture = renderer_->Render(*context_, scene, artifacts, camera, options);
    EXPECT_TRUE(picture.ok()) << picture.status();
    if (!picture.ok())
      return {.width = options.width,
              .height = options.height,
              .pixels = std::vector<Vec4>(options.width * options.height)};
    return *std::move(picture);
  }

  // Each pixel must show `expected` of the point on the floor (y = 0) that it sees.
  void ExpectFloor(const Picture& picture, const std::function<Vec3(Vec3)>& expected,
                   double tolerance) {
    double worst = 0;
    int worst_x = 0, worst_y = 0;
    for (int y = 0; y < picture.height; ++y) {
      for (int x = 0; x < picture.width; ++x) {
        const Vec3 point = HitPlane(kAbove, picture, x, y, Vec3(0), Vec3(0, 1, 0));
        const Vec3 wanted = expected(point);
        for (int c = 0; c < 3; ++c) {
          const double error = std::abs(double{picture.At(x, y)[c]} - wanted[c]) / wanted[c];
          if (!(error <= worst)) worst = error, worst_x = x, worst_y = y;
        }
      }
    }
    EXPECT_LE(worst, tolerance) << "worst at pixel " << worst_x << ", " << worst_y;
  }

  std::unique_ptr<ThinRenderer> renderer_;
};

// 2e-5: the twins agree within that (form_factor_glsl_test), and a pixel's place is known to 1e-6.
constexpr double kTolerance = 4e-5;

TEST_F(LightingTest, UnoccludedFloorIsTheClosedFormOfEachKindOfLight) {
  const LightShape shapes[] = {
      Lamp().shape,
      DiskLight{.center = {0.3f, 1.4f, 0},
                .normal = {0.2f, -1, 0},
                .radius = 0.4f,
                .radiance = {3, 2, 1}},
      SphereLight{.center = {-0.6f, 0.9f, 0}, .radius = 0.5f, .radiance = {3, 2, 1}},
      PointLight{.position = {0.5f, 1.2f, -0.3f}, .intensity = {3, 2, 1}},
      SpotLight{.position = {0.5f, 2, 0},
                .direction = {-0.2f, -1, 0},
                .intensity = {3, 2, 1},
                .inner_angle = 0.2f,
                .outer_angle = 0.9f},
      DistantLight{.to_light = {0.3f, 1, 0.2f}, .angular_diameter = 0.1f, .irradiance = {3, 2, 1}}};
  for (const LightShape& shape : shapes) {
    SCOPED_TRACE(shape.index());
    const AreaLight light = {.id = "lamp", .shape = shape};
    const auto scene = SceneOf({.upsert_instances = {Floor()}, .upsert_lights = {light}});
    ExpectFloor(
        Render(*scene, {}),
        [&](Vec3 point) {
          return kFloorColor * (kAmbient + UnoccludedRadiance(light, point, Vec3(0, 1, 0)));
        },
        kTolerance);
  }
}

TEST_F(LightingTest, LightsAddUpAndTilesMeet) {
  AreaLight second = {.id = "second",
                      .shape = PointLight{.position = {1, 1, 1}, .intensity = {0, 1, 2}}};
  const auto scene = SceneOf({.upsert_instances = {Floor()}, .upsert_lights = {Lamp(), second}});
  RenderOptions large = kSmall;  // more than one tile each way
  large.width = 1300;
  large.height = 1100;
  ExpectFloor(
      Render(*scene, {}, large),
      [&](Vec3 point) {
        return kFloorColor * (kAmbient + UnoccludedRadiance(Lamp(), point, Vec3(0, 1, 0)) +
                              UnoccludedRadiance(second, point, Vec3(0, 1, 0)));
      },
      kTolerance);
}

Receiver FloorReceiver(uint32_t width = 16, uint32_t height = 12) {
  return {.id = "patch",
          .shape = Parallelogram{.origin = {-4, 0, 4}, .edge_u = {8, 0, 0}, .edge_v = {0, 0, -8}},
          .width = width,
          .height = height,
          .reflectance = kFloorColor};
}

TEST_F(LightingTest, TexturedAndUntexturedSurfacesMatchWhereNothingIsOccluded) {
  const auto scene = SceneOf({.upsert_lights = {Lamp()}, .upsert_receivers = {FloorReceiver()}});
  const auto all = ArtifactOf(*scene, "lamp", "patch", 64, [](uint32_t, uint32_t) { return 64; });
  const Picture textured = Render(*scene, {all}), untextured = Render(*scene, {});
  const auto floor_scene = SceneOf({.upsert_instances = {Floor()}, .upsert_lights = {Lamp()}});
  const Picture instance = Render(*floor_scene, {});
  for (size_t i = 0; i < textured.pixels.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      ASSERT_FLOAT_EQ(textured.pixels[i][c], untextured.pixels[i][c]) << "pixel " << i;
      ASSERT_NEAR(textured.pixels[i][c], instance.pixels[i][c], kTolerance * instance.pixels[i][c])
          << "pixel " << i;
    }
  }
}

// Counts that differ along u and v, so that a turned, mirrored or transposed texture shows.
TEST_F(LightingTest, CountsScaleTheirOwnLightAlone) {
  const AreaLight other = {.id = "other",
                           .shape = PointLight{.position = {1, 2, 1}, .intensity = {1, 1, 1}}};
  const auto scene =
      SceneOf({.upsert_lights = {Lamp(), other}, .upsert_receivers = {FloorReceiver()}});
  const auto counts = [](uint32_t i, uint32_t j) { return (3 * i + 5 * j) % 33; };
  const auto artifact = ArtifactOf(*scene, "lamp", "patch", 32, counts);
  const auto fraction = [&](Vec3 point) {
    const double x = (point.x + 4) / 8 * 16 - 0.5, y = (4 - point.z) / 8 * 12 - 0.5;
    const double i = std::floor(x), j = std::floor(y);
    double sum = 0;
    for (const double di : {0.0, 1.0}) {
      for (const double dj : {0.0, 1.0}) {
        const auto at = counts(static_cast<uint32_t>(std::clamp(i + di, 0.0, 15.0)),
                               static_cast<uint32_t>(std::clamp(j + dj, 0.0, 11.0)));
        sum += (1 - std::abs(x - i - di)) * (1 - std::abs(y - j - dj)) * at / 32.0;
      }
    }
    return static_cast<float>(sum);
  };
  ExpectFloor(
      Render(*scene, {artifact}),
      [&](Vec3 point) {
        return kFloorColor *
               (kAmbient + fraction(point) * UnoccludedRadiance(Lamp(), point, Vec3(0, 1, 0)) +
                UnoccludedRadiance(other, point, Vec3(0, 1, 0)));
      },
      1e-4);
}

TEST_F(LightingTest, APlanarInstanceShowsItsReceiversArtifact) {
  const auto scene =
      SceneOf({.upsert_instances = {Floor()},
               .upsert_lights = {Lamp()},
               .upsert_receivers = {
                   {.id = "patch", .shape = PlanarInstance{"floor"}, .width = 8, .height = 8}}});
  const auto half = ArtifactOf(*scene, "lamp", "patch", 8, [](uint32_t, uint32_t) { return 4; });
  ExpectFloor(
      Render(*scene, {half}),
      [&](Vec3 point) {
        return kFloorColor * (kAmbient + 0.5f * UnoccludedRadiance(Lamp(), point, Vec3(0, 1, 0)));
      },
      kTolerance);
}

TEST_F(LightingTest, AnInstanceThatDoesNotReceiveShowsNoShadow) {
  Instance floor = Floor();
  floor.receives = false;
  const auto scene =
      SceneOf({.upsert_instances = {floor},
               .upsert_lights = {Lamp()},
               .upsert_receivers = {
                   {.id = "patch", .shape = PlanarInstance{"floor"}, .width = 8, .height = 8}}});
  const auto none = ArtifactOf(*scene, "lamp", "patch", 8, [](uint32_t, uint32_t) { return 0; });
  EXPECT_EQ(Render(*scene, {none}).pixels, Render(*scene, {}).pixels);
}

TEST_F(LightingTest, ABoxThatStandsOnAReceiverIsNotDarkenedByIt) {
  const Instance box = {
      .id = "box", .mesh = Cuboid({-1, 0, -1}, {1, 0.5f, 1}), .color = Vec3(0.6f)};
  const auto scene = SceneOf({.upsert_instances = {box},
                              .upsert_lights = {Lamp()},
                              .upsert_receivers = {FloorReceiver()}});
  const auto none = ArtifactOf(*scene, "lamp", "patch", 8, [](uint32_t, uint32_t) { return 0; });
  const Picture dark = Render(*scene, {none}), lit = Render(*scene, {});
  const Vec4 top = dark.At(48, 32);
  EXPECT_EQ(top, lit.At(48, 32));
  EXPECT_GT(top.x, 0.1f);
  const Vec4 corner = dark.At(1, 62);
  for (int c = 0; c < 3; ++c) EXPECT_FLOAT_EQ(corner[c], kFloorColor[c] * kAmbient[c]);
}

// Seen from below; the lamp is below as well.
TEST_F(LightingTest, TheBackOfAOneSidedReceiverStaysDark) {
  const AreaLight below = {.id = "lamp",
                           .shape = PointLight{.position = {0, -2, 0}, .intensity = Vec3(9)}};
  const Camera from_below = {.eye = {0, -5, 3}, .target = {0, 0, 0}, .fov_y_deg = 25};
  for (const bool two_sided : {false, true}) {
    SCOPED_TRACE(two_sided);
    Receiver receiver = FloorReceiver();
    receiver.two_sided = two_sided;
    const auto scene = SceneOf({.upsert_lights = {below}, .upsert_receivers = {receiver}});
    const auto all = ArtifactOf(*scene, "lamp", "patch", 8, [](uint32_t, uint32_t) { return 8; });
    const Picture picture = Render(*scene, {all}, kSmall, from_below);
    if (two_sided) {
      EXPECT_GT(picture.At(48, 32).x, 0.1f);
    } else {
      EXPECT_FLOAT_EQ(picture.At(48, 32).x, kFloorColor.x * kAmbient.x);
    }
  }
}

TEST_F(LightingTest, ArtifactsOfWhatIsGoneAreIgnored) {
  const auto before = SceneOf({.upsert_lights = {Lamp()}, .upsert_receivers = {FloorReceiver()}});
  const auto none = ArtifactOf(*before, "lamp", "patch", 8, [](uint32_t, uint32_t) { return 0; });
  const auto after = SceneOf({.upsert_instances = {Floor()}, .upsert_lights = {Lamp()}});
  EXPECT_EQ(Render(*after, {none, nullptr}).pixels, Render(*after, {}).pixels);
}

}  // namespace
}  // namespace penumbra
