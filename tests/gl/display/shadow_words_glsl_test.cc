// The GLSL look-up of layers and of widths against Visibility(), and of a picture's pixels.
#include "client/display/shadow_words_glsl.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <span>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client/display/form_factor_glsl.h"
#include "client/display/light_above_plane_glsl.h"
#include "client/display/shadow_words.h"
#include "render/artifact/light_above_plane.h"
#include "render/gl/buffer.h"
#include "render/gl/draw.h"
#include "render/gl/program.h"
#include "tests/gl/display/software_context.h"
#include "tests/support/random_ldi.h"
#include "tests/support/random_width_map.h"

namespace penumbra {
namespace {

constexpr int kPoints = 8192;

constexpr char kComputeGlsl[] = R"(
layout(local_size_x = 64) in;
struct Place { vec4 point; vec4 normal; };
layout(std430, binding = 3) readonly buffer Lights { Light lights[]; };
layout(std430, binding = 4) readonly buffer Places { Place places[]; };
layout(std430, binding = 5) buffer Results { vec4 results[]; };
void main() {
  uint i = gl_GlobalInvocationID.x;
  vec3 point = places[i].point.xyz, n = places[i].normal.xyz;
  float value = -2.0;
  vec3 inside = point + places[i].point.w * vec3(1.0, 0.0, 0.0);
  bool is_found = FindInPicture(0, point, inside, value);
  results[i] = vec4(HasLayers(0) ? LayerVisibility(0, point, n) : -1.0,
                    LightAbovePlane(lights[0], point, n), is_found ? value : -2.0,
                    HasWidths(0) ? WidthVisibility(0, point, n) : -1.0);
})";

struct Place {
  Vec4 point;  // w: how far right of it some of the face is
  Vec4 normal;
};

class ShadowWordsGlslTest : public SoftwareContextTest {
 protected:
  std::vector<Vec4> Run(const AreaLight& light, const ShadowWords& words, const LightShadow& shadow,
                        const std::vector<Place>& places) {
    auto program = gl::Program::Create(
        *context_, {.compute = absl::StrCat(FormFactorGlsl(), LightAbovePlaneGlsl(),
                                            ShadowWordsGlsl({.shadows = 0, .faces = 1, .words = 2}),
                                            kComputeGlsl)});
    EXPECT_TRUE(program.ok()) << program.status();
    if (!program.ok()) return {};
    std::vector<Vec4> results(places.size());
    std::vector<gl::Buffer> buffers;
    const GpuLight gpu_light = ToGpu(light);
    for (const std::span<const std::byte> bytes :
         {std::as_bytes(std::span(&shadow, 1)), std::as_bytes(std::span(words.faces)),
          std::as_bytes(std::span(words.words)), std::as_bytes(std::span(&gpu_light, 1)),
          std::as_bytes(std::span(places)), std::as_bytes(std::span(results))}) {
      auto buffer =
          bytes.empty() ? gl::Buffer::Create(*context_, 16) : gl::Buffer::Create(*context_, bytes);
      EXPECT_TRUE(buffer.ok()) << buffer.status();
      if (!buffer.ok()) return {};
      buffer->BindStorage(*context_, static_cast<uint32_t>(buffers.size()));
      buffers.push_back(*std::move(buffer));
    }
    gl::Dispatch(*context_, *program, static_cast<uint32_t>(places.size() / 64));
    EXPECT_TRUE(buffers.back().Read(*context_, 0, std::as_writable_bytes(std::span(results))).ok());
    return results;
  }
};

Vec3 RandomDirection(std::mt19937& random) {
  std::normal_distribution<float> normal;
  return glm::normalize(Vec3(normal(random), normal(random), normal(random)));
}

// Half of them on a layer, the rest anywhere.
std::vector<Place> PlacesAround(const AttenuationLdi& ldi, std::mt19937& random) {
  std::vector<Place> places;
  std::uniform_real_distribution<double> unit(0, 1);
  while (places.size() < kPoints) {
    const LdiFace& face = ldi.faces[random() % ldi.faces.size()];
    const DVec2 at(unit(random) * face.view.width, unit(random) * face.view.height);
    const size_t pixel = static_cast<size_t>(at.y) * face.view.width + static_cast<size_t>(at.x);
    double depth = face.view.near + unit(random) * (face.view.far - face.view.near);
    const uint32_t layers = face.offsets[pixel + 1] - face.offsets[pixel];
    if (random() % 2 == 0 && layers > 0) {
      depth = double{face.depths[face.offsets[pixel] + random() % layers]};
    }
    places.push_back(
        {Vec4(Vec3(face.view.PointAt(at, depth)), 0), Vec4(RandomDirection(random), 0)});
  }
  return places;
}

TEST_F(ShadowWordsGlslTest, LayersAreFoundAsOnTheCpu) {
  std::mt19937 random(11);
  AttenuationLdi ldi = RandomLdi(300);
  // A light that all of every surface's half space has something of would hide nothing; this one
  // has all of it above every plane or none.
  ldi.light.shape = PointLight{.position = Vec3(ldi.faces[0].view.frame.origin)};
  ShadowWords words;
  LightShadow shadow;
  words.Append(ldi, shadow);
  const std::vector<Place> places = PlacesAround(ldi, random);
  const std::vector<Vec4> results = Run(ldi.light, words, shadow, places);
  ASSERT_EQ(results.size(), places.size());
  int different = 0, partly = 0;
  for (size_t i = 0; i < places.size(); ++i) {
    const float expected = Visibility(ldi, Vec3(places[i].point), Vec3(places[i].normal));
    const float found = std::min(results[i].x, results[i].y);
    // At a tolerance's very edge rounding decides.
    different += std::abs(found - expected) > 1e-3f;
    partly += expected > 0 && expected < 1;
  }
  EXPECT_LT(different, kPoints / 500);
  EXPECT_GT(partly, kPoints / 5);
}

// Half of them at a blocker's depth or a little behind it, the rest anywhere.
std::vector<Place> PlacesAround(const ShadowWidthMap& map, std::mt19937& random) {
  std::vector<Place> places;
  std::uniform_real_distribution<double> unit(0, 1);
  while (places.size() < kPoints) {
    const ShadowWidthFace& face = map.faces[random() % map.faces.size()];
    const DVec2 at(unit(random) * face.view.width, unit(random) * face.view.height);
    const size_t texel = static_cast<size_t>(at.y) * face.view.width + static_cast<size_t>(at.x);
    double depth = face.view.near + unit(random) * (face.view.far - face.view.near);
    if (random() % 2 == 0 && face.near.depths[texel] != kNoDepth) {
      depth = face.near.depths[texel] + 0.5 * unit(random);
    }
    places.push_back(
        {Vec4(Vec3(face.view.PointAt(at, depth)), 0), Vec4(RandomDirection(random), 0)});
  }
  return places;
}

TEST_F(ShadowWordsGlslTest, WidthsAreFoundAsOnTheCpu) {
  std::mt19937 random(12);
  for (const bool has_far : {false, true}) {
    for (const bool is_automatic : {false, true}) {
      ShadowWidthMap map = RandomWidthMap(7, has_far);
      if (has_far) map.light.shape = SphereLight{.center = {1, 2, 3}, .radius = 0.3f};
      if (!is_automatic) map.c_scale = 0.7f, map.c_bias = 0.05f;
      ShadowWords words;
      LightShadow shadow;
      words.Append(map, shadow);
      const std::vector<Place> places = PlacesAround(map, random);
      const std::vector<Vec4> results = Run(map.light, words, shadow, places);
      ASSERT_EQ(results.size(), places.size());
      int different = 0, partly = 0;
      for (size_t i = 0; i < places.size(); ++i) {
        const float expected = Visibility(map, Vec3(places[i].point), Vec3(places[i].normal));
        const float found = std::min(results[i].w, results[i].y);
        different += !(std::abs(found - expected) <= 2e-3f);
        partly += expected > 0 && expected < 1;
      }
      EXPECT_LT(different, kPoints / 400) << has_far << is_automatic;
      EXPECT_GT(partly, kPoints / 10) << has_far << is_automatic;
    }
  }
}

TEST_F(ShadowWordsGlslTest, LightAbovePlaneIsAsOnTheCpu) {
  const LightShape shapes[] = {
      RectangleLight{.corner = {-1, 1, -1}, .edge_u = {2, 0.3f, 0}, .edge_v = {0.2f, 0, 1}},
      RectangleLight{
          .corner = {-1, 0, -1}, .edge_u = {2, 0, 0}, .edge_v = {0, 0, 2}, .two_sided = false},
      DiskLight{.center = {0, 1, 0}, .normal = {0.2f, -1, 0}, .radius = 1.5f},
      SphereLight{.center = {0, 1, 0}, .radius = 0.7f},
      PointLight{.position = {0, 1, 0}},
      DistantLight{.to_light = {0.3f, 1, 0}, .angular_diameter = 1.2f},
      DistantLight{.to_light = {0.3f, 1, 0}, .angular_diameter = 0.00925f},
  };
  std::mt19937 random(3);
  std::uniform_real_distribution<float> side(-2, 2);
  for (const LightShape& shape : shapes) {
    const AreaLight light{.id = "l", .shape = shape};
    std::vector<Place> places;
    for (int i = 0; i < kPoints; ++i) {
      places.push_back(
          {Vec4(side(random), side(random), side(random), 0), Vec4(RandomDirection(random), 0)});
    }
    const auto results = Run(light, {}, {}, places);
    ASSERT_EQ(results.size(), places.size());
    for (int i = 0; i < kPoints; ++i) {
      const float expected = LightAbovePlane(light, Vec3(places[i].point), Vec3(places[i].normal));
      ASSERT_NEAR(results[i].y, expected, 2e-3f) << "light " << shape.index() << ", place " << i;
      EXPECT_EQ(results[i].x, -1.0f);
    }
  }
}

TEST_F(ShadowWordsGlslTest, PixelsAreFoundByPlace) {
  // The plane z = 0 fills the picture from −1 to 1.
  ViewShadow view;
  view.points =
      PicturePixels{.camera = {.eye = {0, 0, 5}, .target = {0, 0, 0}, .fov_y_deg = 22.619865f},
                    .width = 8,
                    .height = 8,
                    .crop = {.x = 2, .y = 1, .width = 4, .height = 4}};
  view.light = {.id = "l", .shape = PointLight{.intensity = {1, 4, 2}}};
  view.visibility = {4, 4, 8, std::vector<uint16_t>(16, 8)};
  view.radiance = RadianceTexture{.width = 4, .height = 4, .texels = {}};
  auto mask = std::make_shared<CoverageMask>(4, 4);
  for (size_t i = 0; i < 16; ++i) {
    view.radiance->texels.push_back(0.1f * static_cast<float>(i) * Vec3(1, 4, 2));
    if (i != 5) mask->Set(i);
  }
  view.coverage = mask;
  ShadowWords words;
  LightShadow shadow;
  words.Append(view, shadow);
  std::vector<Place> places;
  for (int i = 0; i < 64; ++i) {
    places.push_back(
        {Vec4(-1 + 0.25f * (i % 8 + 0.5f), 1 - 0.25f * (i / 8 + 0.5f), 0, 0), Vec4(0, 0, 1, 0)});
  }
  auto results = Run(view.light, words, shadow, places);
  ASSERT_EQ(results.size(), 64u);
  const auto expected = [](int x, int y) {
    const int i = (y - 1) * 4 + x - 2;
    return x < 2 || x > 5 || y < 1 || y > 4 || i == 5 ? -2.0f : 0.1f * static_cast<float>(i);
  };
  for (int i = 0; i < 64; ++i) EXPECT_NEAR(results[i].z, expected(i % 8, i / 8), 1e-6f) << i;
  // Faces that have only what lies right of a pixel's centre take the pixel to the right.
  for (Place& place : places) place.point.w = 0.05f;
  results = Run(view.light, words, shadow, places);
  for (int i = 0; i < 64; ++i) EXPECT_NEAR(results[i].z, expected(i % 8 + 1, i / 8), 1e-6f) << i;
}

}  // namespace
}  // namespace penumbra
