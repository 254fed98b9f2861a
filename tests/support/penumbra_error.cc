#include "tests/support/penumbra_error.h"

#include <cmath>

#include "render/technique/technique.h"

namespace penumbra::testing {
namespace {

constexpr uint32_t kReferenceSeeds = 4;  // of 1,024 samples each
constexpr uint64_t kFirstReferenceSeed = 1'000'000;

std::vector<double> FractionsWith(const Scene& scene, uint32_t samples, uint64_t seed) {
  const ArtifactSpec spec{.params = SoftTextureParams{.samples = samples, .seed = seed},
                          .light_id = "light",
                          .receiver_id = "receiver"};
  tbb::task_arena arena;
  const Artifact artifact =
      TechniqueFor(spec.params).Compute(scene, spec, {.arena = arena}).value();
  const VisibilityMap& map = std::get<SoftShadowTexture>(artifact.payload).visibility;
  std::vector<double> fractions;
  fractions.reserve(map.counts.size());
  for (const uint16_t count : map.counts) fractions.push_back(static_cast<double>(count) / samples);
  return fractions;
}

}  // namespace

std::vector<PenumbraError> PenumbraErrors(const Scene& scene, std::span<const uint32_t> counts,
                                          uint64_t seeds) {
  std::vector<double> reference;
  for (uint32_t k = 0; k < kReferenceSeeds; ++k) {
    const auto fractions = FractionsWith(scene, 1024, kFirstReferenceSeed + k);
    reference.resize(fractions.size());
    for (size_t t = 0; t < fractions.size(); ++t) reference[t] += fractions[t] / kReferenceSeeds;
  }
  std::vector<PenumbraError> errors;
  for (const uint32_t samples : counts) {
    double sum2 = 0;
    uint64_t texels = 0;
    for (uint64_t seed = 1; seed <= seeds; ++seed) {
      const auto fractions = FractionsWith(scene, samples, seed);
      for (size_t t = 0; t < fractions.size(); ++t) {
        if (reference[t] <= 0 || reference[t] >= 1) continue;
        sum2 += (fractions[t] - reference[t]) * (fractions[t] - reference[t]);
        ++texels;
      }
    }
    errors.push_back({samples, std::sqrt(sum2 / static_cast<double>(texels))});
  }
  return errors;
}

double FittedExponent(std::span<const PenumbraError> errors) {
  const auto n = static_cast<double>(errors.size());
  double x = 0, y = 0, xx = 0, xy = 0;
  for (const PenumbraError& e : errors) {
    const double u = std::log(e.samples), v = std::log(e.rmse);
    x += u;
    y += v;
    xx += u * u;
    xy += u * v;
  }
  return (n * xy - x * y) / (n * xx - x * x);
}

}  // namespace penumbra::testing
