#include "tests/conformance/conformance.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <type_traits>
#include <utility>

#include "render/engine/compute_once.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {

TechniqueParams With(TechniqueParams params, uint32_t samples, uint64_t seed) {
  std::visit(
      [&](auto& p) {
        if constexpr (requires { p.samples; }) p.samples = samples;
        if constexpr (requires { p.seed; }) p.seed = seed;
        // What holds for images holds for small ones, sooner.
        if constexpr (requires { p.max_layers; }) p.resolution = 160;
      },
      params);
  return params;
}

SceneDelta Stage::delta() const {
  Receiver named = receiver;
  named.id = "receiver";
  SceneDelta delta{.upsert_instances = occluders,
                   .upsert_lights = {{"light", light}},
                   .upsert_receivers = {named}};
  for (size_t i = 0; i < occluders.size(); ++i) {
    if (occluders[i].id.empty()) delta.upsert_instances[i].id = "occluder" + std::to_string(i);
  }
  return delta;
}

namespace {

GivenPoints TexelCentersOf(const ReceiverPatch& receiver) {
  auto points = std::make_shared<std::vector<SurfacePoint>>();
  for (uint32_t j = 0; j < receiver.height; ++j) {
    for (uint32_t i = 0; i < receiver.width; ++i) {
      points->push_back({receiver.TexelCenter(i, j), receiver.patch.normal()});
    }
  }
  return {std::move(points)};
}

}  // namespace

std::vector<float> VisibilityGrid(const Scene& scene, const Artifact& artifact) {
  const ReceiverPatch receiver = scene.ResolveReceiver("receiver").value();
  const Vec3 normal = receiver.patch.normal();
  std::vector<float> grid;
  if (const auto* view = std::get_if<ViewShadow>(&artifact.payload)) {
    EXPECT_EQ(view->visibility.counts.size(), size_t{receiver.width} * receiver.height);
    for (uint32_t i = 0; i < view->visibility.width; ++i) {
      grid.push_back(view->visibility.Fraction(i, 0));
    }
    return grid;
  }
  for (uint32_t j = 0; j < receiver.height; ++j) {
    for (uint32_t i = 0; i < receiver.width; ++i) {
      grid.push_back(Visibility(artifact, receiver.TexelCenter(i, j), normal));
    }
  }
  return grid;
}

ConformanceTest::ConformanceTest() : engine_(EnginesUnderTest()[std::get<0>(GetParam())].make()) {}

TechniqueParams ConformanceTest::params(uint32_t samples, uint64_t seed) const {
  return With(AllTechniques()[std::get<1>(GetParam())], samples, seed);
}

ArtifactSpec ConformanceTest::Spec(const std::string& scene_id, uint32_t samples,
                                   uint64_t seed) const {
  ArtifactSpec spec{.params = params(samples, seed), .light_id = "light"};
  if (target() == SpecTarget::kReceiver) spec.receiver_id = "receiver";
  if (target() != SpecTarget::kPoints) return spec;
  const auto scene = engine_->Snapshot(scene_id);
  // Where there is no scene any points do.
  const auto receiver = scene.ok() ? (*scene)->ResolveReceiver("receiver") : scene.status();
  spec.points = TexelCentersOf(receiver.ok() ? *receiver : ReceiverPatch{.width = 1, .height = 1});
  return spec;
}

void ConformanceTest::ExpectAlike(const std::vector<float>& a, const std::vector<float>& b,
                                  float tolerance, float differing_part, const std::string& what) {
  if (target() == SpecTarget::kScene) {
    EXPECT_LT(MeanDifference(a, b), 0.02f) << what;
    EXPECT_LT(DifferingPart(a, b, 0.25f), 0.02f) << what;
    return;
  }
  // What is predicted at a point goes by the points before it.
  if (target() == SpecTarget::kPoints) differing_part = std::max(differing_part, 0.03f);
  EXPECT_LE(DifferingPart(a, b, 0), differing_part) << what;
  EXPECT_EQ(DifferingPart(a, b, tolerance), 0) << what;
}

std::string ConformanceTest::NewScene(const SceneDelta& delta) {
  const std::string id = "scene" + std::to_string(scenes_made_++);
  EXPECT_TRUE(engine_->CreateScene(id).ok());
  const auto revision = engine_->Commit(id, delta);
  EXPECT_TRUE(revision.ok()) << revision.status();
  return id;
}

std::shared_ptr<const Artifact> ConformanceTest::Compute(const std::string& scene_id,
                                                         const ArtifactSpec& spec) {
  return ComputeOnce(*engine_, scene_id, spec).value();
}

std::vector<float> ConformanceTest::Visibilities(const std::string& scene_id,
                                                 const ArtifactSpec& spec) {
  const auto artifact = Compute(scene_id, spec);
  return VisibilityGrid(*engine_->Snapshot(scene_id).value(), *artifact);
}

std::vector<float> ConformanceTest::Visibilities(const Stage& stage, uint32_t samples,
                                                 uint64_t seed) {
  const std::string id = NewScene(stage.delta());
  auto grid = Visibilities(id, Spec(id, samples, seed));
  EXPECT_TRUE(engine_->DeleteScene(id).ok());
  return grid;
}

std::string ConformanceName(const std::tuple<size_t, size_t>& param) {
  return EnginesUnderTest()[std::get<0>(param)].name + "_" +
         std::string(InfoOf(AllTechniques()[std::get<1>(param)]).name);
}

float Mean(const std::vector<float>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0f) / static_cast<float>(values.size());
}

float MeanDifference(const std::vector<float>& a, const std::vector<float>& b) {
  EXPECT_EQ(a.size(), b.size());
  double sum = 0;
  for (size_t t = 0; t < a.size(); ++t) sum += std::abs(a[t] - b[t]);
  return static_cast<float>(sum / static_cast<double>(a.size()));
}

float DifferingPart(const std::vector<float>& a, const std::vector<float>& b, float tolerance) {
  EXPECT_EQ(a.size(), b.size());
  size_t differing = 0;
  for (size_t t = 0; t < a.size(); ++t) differing += !(std::abs(a[t] - b[t]) <= tolerance);
  return static_cast<float>(differing) / static_cast<float>(a.size());
}

std::vector<std::pair<std::string, LightShape>> LightsOverhead() {
  return {
      {"rectangle", RectangleLight{.corner = Vec3(-0.3f, 2, -0.2f),
                                   .edge_u = Vec3(0.6f, 0, 0),
                                   .edge_v = Vec3(0.1f, 0.1f, 0.5f)}},
      {"disk", DiskLight{.center = Vec3(0.1f, 2, 0), .normal = Vec3(0.2f, -1, 0), .radius = 0.4f}},
      {"sphere", SphereLight{.center = Vec3(0, 2, 0.1f), .radius = 0.3f}},
      {"point", PointLight{.position = Vec3(0.1f, 2, -0.1f)}},
      // Its cone holds all of the floor: beyond it nobody need know what is hidden.
      {"spot", SpotLight{.position = Vec3(-0.1f, 2, 0.1f), .outer_angle = 0.9f}},
      {"distant", DistantLight{.to_light = Vec3(0.1f, 1, 0.2f), .angular_diameter = 0.2f}}};
}

Receiver OddFloor() {
  Receiver floor = FloorReceiver("receiver", 4, 37);
  floor.height = 29;
  return floor;
}

Instance BoxOver(Vec3 center, Vec3 half) {
  return {.id = {}, .mesh = MeshOf(UnitBoxGeometry()), .world_from_mesh = Placed(center, half)};
}

Instance SheetOver(Vec3 center, Vec3 half) {
  return {.id = {}, .mesh = MeshOf(UnitSquareGeometry()), .world_from_mesh = Placed(center, half)};
}

}  // namespace penumbra::testing
