#include "tests/accuracy/exactness.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "render/reference/exact_ray.h"
#include "render/reference/ray_visibility.h"

namespace penumbra::testing {
namespace {

// Rounding that a correct single-precision computation may show: this many units in the last place
// of the largest coordinate. Vertices are rounded once in the world and once relative to the
// receiver, and an edge of a triangle is drawn from products of those.
constexpr double kToleranceUlps = 8;

double LargestCoordinate(DVec3 p) {
  const DVec3 a = glm::abs(p);
  return std::max({a.x, a.y, a.z});
}

// Judges the texels where counts differ.
class Judge {
 public:
  Judge(const Scene& scene, const SoftShadowTexture& texture,
        const std::vector<LightSample>& samples, double surface_offset)
      : exact_(scene), texture_(texture), samples_(samples), surface_offset_(surface_offset) {
    double largest = exact_.largest_coordinate();
    const Parallelogram& patch = texture.receiver.patch;
    for (const Vec2 uv : {Vec2(0, 0), Vec2(1, 0), Vec2(0, 1), Vec2(1, 1)}) {
      largest = std::max(largest, LargestCoordinate(DVec3(patch.At(uv))));
    }
    for (const LightSample& sample : samples) {
      if (!sample.at_infinity) largest = std::max(largest, LargestCoordinate(DVec3(sample.point)));
    }
    ulp_ = std::ldexp(largest, -23);
  }

  // Counts below the least or above the most that doubtful rays allow are unexplained.
  void Add(uint32_t i, uint32_t j, int count, Exactness& result) const {
    const DVec3 origin(texture_.receiver.TexelCenter(i, j));
    const double tolerance = kToleranceUlps * ulp_;
    int certainly_visible = 0;
    std::vector<double> doubtful;
    const auto verdicts =
        exact_.Trace(texture_.receiver.patch, origin, samples_, surface_offset_, tolerance);
    for (const ExactVerdict& verdict : verdicts) {
      if (verdict.slack <= tolerance) {
        doubtful.push_back(verdict.slack);
      } else if (!verdict.blocked) {
        ++certainly_visible;
      }
    }
    const int most = certainly_visible + static_cast<int>(doubtful.size());
    result.unexplained += std::max({0, certainly_visible - count, count - most});
    for (const double slack : doubtful) {
      result.largest_slack_ulps = std::max(result.largest_slack_ulps, slack / ulp_);
    }
  }

 private:
  ExactRays exact_;
  const SoftShadowTexture& texture_;
  const std::vector<LightSample>& samples_;
  double surface_offset_;
  double ulp_ = 0;
};

// docs/techniques/soft_texture.md: occluders within 2⁻¹⁹ of the receiver's largest coordinate, or
// of its size, do not count. A technique that left out more would have rays do the same.
void ExpectStatedOffset(const Parallelogram& patch, double offset) {
  double largest = glm::length(DVec3(patch.edge_u)) + glm::length(DVec3(patch.edge_v));
  for (const float u : {0.0f, 1.0f}) {
    for (const float v : {0.0f, 1.0f}) {
      const Vec3 corner = patch.At(Vec2(u, v));
      for (int c = 0; c < 3; ++c) largest = std::max(largest, std::abs(double{corner[c]}));
    }
  }
  EXPECT_NEAR(offset, largest / 524288, 1e-12 * largest);
}

}  // namespace

void Exactness::Add(const Exactness& other) {
  texel_samples += other.texel_samples;
  differing += other.differing;
  unexplained += other.unexplained;
  occluded += other.occluded;
  largest_slack_ulps = std::max(largest_slack_ulps, other.largest_slack_ulps);
}

double Exactness::differing_fraction() const {
  return static_cast<double>(differing) / static_cast<double>(texel_samples);
}

Exactness CompareWithRays(const Scene& scene, const Artifact& artifact) {
  const auto& texture = std::get<SoftShadowTexture>(artifact.payload);
  const auto& samples = artifact.header.light_samples;
  const double offset = std::stod(artifact.header.parameters.at("surface_offset_m"));
  ExpectStatedOffset(texture.receiver.patch, offset);
  const RayVisibility rays(scene, RayVisibility::Intersector::kRobust);
  tbb::task_arena arena;
  const VisibilityMap traced = rays.Counts(texture.receiver, samples, offset, arena);

  const Judge judge(scene, texture, samples, offset);
  Exactness result{.texel_samples = traced.counts.size() * samples.size()};
  for (uint32_t j = 0; j < traced.height; ++j) {
    for (uint32_t i = 0; i < traced.width; ++i) {
      const int by_rays = traced.At(i, j), count = texture.visibility.At(i, j);
      result.occluded += samples.size() - by_rays;
      if (count == by_rays) continue;
      result.differing += std::abs(count - by_rays);
      judge.Add(i, j, count, result);
    }
  }
  return result;
}

}  // namespace penumbra::testing
