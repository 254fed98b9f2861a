// Volumes of casters' own edges against counting: how many of the caster's triangles light has met
// before it comes to a place, one by one.
#include "render/technique/shadow_volume/silhouette_volume.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <optional>
#include <string>
#include <vector>

#include "render/artifact/volume_cap.h"
#include "tests/support/random_scene.h"
#include "tests/support/shapes.h"
#include "tests/support/volume_crossings.h"

namespace penumbra {
namespace {

using testing::BallGeometry;
using testing::Dice;
using testing::EyeImage;
using testing::MeshOf;
using testing::UnitBoxGeometry;
using testing::UnitSquareGeometry;
using testing::VolumeCrossings;

constexpr uint32_t kSide = 24;

// Where along from + t · way, t > 0, triangles are met; nullopt where it is too close to an edge.
std::optional<std::vector<double>> Meetings(const Instance& instance, DVec3 from, DVec3 way) {
  std::vector<double> meetings;
  const auto indices = instance.mesh->indices();
  for (size_t i = 0; i < indices.size(); i += 3) {
    DVec3 at[3];
    for (size_t k = 0; k < 3; ++k) {
      at[k] = DVec3(TransformPoint(instance.world_from_mesh,
                                   instance.mesh->positions()[indices[i + k]])) -
              from;
    }
    const double a = glm::dot(way, glm::cross(at[0], at[1]));
    const double b = glm::dot(way, glm::cross(at[1], at[2]));
    const double c = glm::dot(way, glm::cross(at[2], at[0]));
    const double size = std::abs(a) + std::abs(b) + std::abs(c);
    const double least = std::min({a, b, c}), most = std::max({a, b, c});
    if (least < -1e-4 * size && most > 1e-4 * size) continue;
    if (std::min(std::abs(least), std::abs(most)) < 1e-4 * size || size == 0) return std::nullopt;
    const DVec3 normal = glm::cross(at[1] - at[0], at[2] - at[0]);
    const double t = glm::dot(normal, at[0]) / glm::dot(normal, way);
    if (t > 0) meetings.push_back(t);
  }
  return meetings;
}

// Three leaves of one edge, a square, a box, a ball with a hole.
std::vector<Instance> Casters(Dice& dice) {
  const MeshGeometry leaves{
      .positions = {{0, -1, 0}, {0, 1, 0}, {1, 0, 0}, {-1, 0, 0.5f}, {0, 0, -1}},
      .indices = {0, 1, 2, 0, 1, 3, 1, 0, 4}};
  MeshGeometry holed = BallGeometry(8, 6);
  holed.indices.erase(holed.indices.begin() + 60, holed.indices.begin() + 72);
  std::vector<Instance> casters;
  for (const MeshGeometry& mesh : {leaves, UnitSquareGeometry(), UnitBoxGeometry(), holed}) {
    casters.push_back({.id = "caster",
                       .mesh = MeshOf(mesh),
                       .world_from_mesh = dice.AnyAffine(1.0f, dice.InCube(0.5f))});
  }
  return casters;
}

struct Trial {
  Instance caster;
  AreaLight light;
  DVec4 place;  // of the light, homogeneous
  EyeImage eye;
};

// What a pixel's ray begins at and goes along, to a depth of `near` and one more metre.
struct EyeRay {
  DVec3 from, way;
};
EyeRay RayOf(const EyeImage& eye, size_t pixel) {
  const double x = 2 * (static_cast<double>(pixel % kSide) + 0.5) / kSide - 1;
  const double y = 2 * (static_cast<double>(pixel / kSide) + 0.5) / kSide - 1;
  const DMat4 world_from_clip = glm::inverse(eye.clip_from_world);
  const auto at = [&](double z) {
    const DVec4 p = world_from_clip * DVec4(x, y, z, 1);
    return DVec3(p) / p.w;
  };
  const DVec3 a = at(-1), b = at(0.5);
  const auto depth = [&](DVec3 p) { return (eye.clip_from_world * DVec4(p, 1)).w; };
  const DVec3 way = (b - a) / (depth(b) - depth(a));
  return {.from = a + (eye.near - depth(a)) * way, .way = way};
}

// Pixels compared, and how many of them are wrong.
std::pair<size_t, size_t> Compare(const Trial& trial, Dice& dice) {
  const ShadowVolume volume = SilhouetteVolume(trial.caster, trial.light);
  std::vector<double> inverse(kSide * kSide);
  std::vector<DVec3> ends(inverse.size());
  for (size_t pixel = 0; pixel < inverse.size(); ++pixel) {
    const EyeRay ray = RayOf(trial.eye, pixel);
    double reach = dice.Between(0, 6);
    for (const double t : Meetings(trial.caster, ray.from, ray.way).value_or(std::vector{0.0})) {
      reach = std::min(reach, 0.999 * t);  // no further than what is seen
    }
    inverse[pixel] = 1 / (trial.eye.near + reach);
    ends[pixel] = ray.from + reach * ray.way;
  }
  VolumeCrossings crossings(trial.eye, inverse);
  crossings.Add(volume.vertices, volume.indices, volume.weights);
  crossings.AddCaps(VolumeCapper(volume, 0, trial.light)
                        .CapsFor(trial.eye.clip_from_world, trial.eye.near)
                        .corners);
  size_t compared = 0, wrong = 0;
  for (size_t pixel = 0; pixel < inverse.size(); ++pixel) {
    const DVec3 way = DVec3(trial.place) - trial.place.w * ends[pixel];
    const auto meetings = Meetings(trial.caster, ends[pixel], way);
    if (!meetings) continue;
    int expected = 0;
    for (const double t : *meetings) expected += trial.place.w == 0 || t < 1;
    ++compared;
    wrong += crossings.Count(pixel) != expected;
  }
  return {compared, wrong};
}

TEST(SilhouetteVolumeTest, CountsAreThoseOfSurfacesBefore) {
  Dice dice(41);
  size_t compared = 0, wrong = 0;
  for (int round = 0; round < 30; ++round) {
    for (const Instance& caster : Casters(dice)) {
      const DVec3 way(dice.Direction());
      const bool is_far = round % 2;
      const Vec3 place(is_far ? way : 4.0 * way);
      Trial trial{.caster = caster,
                  .light = {.id = "light", .shape = PointLight{.position = place}}};
      if (is_far) trial.light.shape = DistantLight{.to_light = place};
      trial.place = DVec4(DVec3(place), is_far ? 0 : 1);
      const DVec3 eye = 3.0 * DVec3(dice.InCube(1));
      const double near = dice.Between(0.1f, 2);
      trial.eye = {.clip_from_world = glm::perspective(1.0, 1.0, near, 50.0) *
                                      glm::lookAt(eye, DVec3(dice.InCube(1)), DVec3(0.1, 1, 0.2)),
                   .width = kSide,
                   .height = kSide,
                   .near = near};
      const auto [all, bad] = Compare(trial, dice);
      EXPECT_LE(bad, 4u) << round;
      compared += all;
      wrong += bad;
    }
  }
  EXPECT_GT(compared, 60'000u);
  EXPECT_LE(wrong, 60u);  // one of 1,000: walls' corners are single precision
}

TEST(SilhouetteVolumeTest, LookupCountsTheCaster) {
  const Instance box{.id = "box", .mesh = MeshOf(UnitBoxGeometry())};
  ShadowVolumeMesh mesh{
      .light = {.id = "light", .shape = PointLight{.position = Vec3(0.1f, 5, 0.2f)}},
      .volumes = {}};
  mesh.volumes.push_back(std::make_shared<ShadowVolume>(SilhouetteVolume(box, mesh.light)));
  EXPECT_EQ(Visibility(mesh, Vec3(0, -3, 0), Vec3(0, 1, 0)), 0.0f);
  EXPECT_EQ(Visibility(mesh, Vec3(0, 2, 0), Vec3(0, 1, 0)), 1.0f);
  EXPECT_EQ(Visibility(mesh, Vec3(4, -3, 0), Vec3(0, 1, 0)), 1.0f);
  EXPECT_EQ(Visibility(mesh, Vec3(4, -3, 0), Vec3(0, -1, 0)), 0.0f);
}

}  // namespace
}  // namespace penumbra
