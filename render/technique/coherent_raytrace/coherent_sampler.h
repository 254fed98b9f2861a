// How much of a light each of many neighbouring points sees, by tracing shadow rays only where that
// is likely to change from one point to the next.
//
//   CoherentSampler sampler(square, tracer, {.side = 16});
//   for (…) const CellMask visible = sampler.Visible(point, index, {});
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "render/technique/coherent_raytrace/cell_mask.h"
#include "render/technique/coherent_raytrace/light_square.h"
#include "render/technique/coherent_raytrace/shadow_tracer.h"

namespace penumbra {

struct SamplingSettings {
  uint32_t side = 16;  // cells along each side of the light, one sample a cell: 1 … 32
  uint64_t seed = 0;
  // Off: every cell of every point is traced.
  bool predicts = true;
  // A blocker in the part of a cell that its sample is in stands for the sample's ray.
  bool skips_known_rays = true;
  // Of the cells at the light's edge that are predicted like their neighbours every other one is
  // traced, at the next point the others.
  bool alternates_exterior = true;
  uint32_t parts = 3;  // of a cell's side; one blocker is kept for each part: 1 … 4
  // From a point further than this from the one before nothing is predicted, in m.
  float prediction_distance = 0.0f;
};

// Cells of whose rays the answer is known beforehand.
struct KnownCells {
  CellMask lit, dark;
};

// Where in the square the samples of a point are, at 32·y + x: a function of seed and point alone.
struct PointSamples {
  void Place(const CellGrid& grid, uint64_t seed, uint64_t point_index);
  Vec2 At(uint32_t cell) const { return {u[cell], v[cell]}; }

  std::array<float, 1024 + kSamplerLanes> u, v;
  std::array<int32_t, 1024 + kSamplerLanes> part;
};

// Not for several threads at once.
//
// Source  Agrawala et al. 2000, §5.2; departs: (1) cells to do are traced together and wrong ones
//         spread afterwards, which reaches the same cells as a queue; (2) a point all of whose
//         light was seen leaves no blockers, and all of the light is then predicted to be seen,
//         where the pseudocode would trace every cell
class CoherentSampler {
 public:
  CoherentSampler(const LightSquare& square, const ShadowTracer& tracer,
                  const SamplingSettings& settings);

  // Forgets the points before.
  void Restart();

  // The cells whose samples the point sees. Samples behind the surface's plane, or on a light whose
  // back it is turned to, are not seen and cost nothing.
  CellMask Visible(const SurfacePoint& point, uint64_t point_index, const KnownCells& known);

  const TraceCounts& counts() const { return counts_; }
  // What was counted since the last time.
  TraceCounts TakeCounts() { return std::exchange(counts_, {}); }

 private:
  struct Prediction {
    CellMask blocked;
    CellMask done;  // of these, by a blocker that is as good as their ray
  };

  Prediction Predict();
  CellMask Below(const Vec3& normal) const;
  CellMask Trace(const SurfacePoint& point, const CellMask& cells);
  // Traces what the prediction leaves open and what then turns out to be wrong.
  CellMask Complete(const SurfacePoint& point, bool uses_prediction, const Prediction& prediction,
                    const KnownCells& known, const CellMask& below);
  bool IsNear(const SurfacePoint& point) const;

  const LightSquare& square_;
  const ShadowTracer& tracer_;
  SamplingSettings settings_;
  const CellGrid grid_;
  TraceCounts counts_;

  LightSquare::Seen seen_;  // of the point at hand
  PointSamples samples_;
  bool has_previous_ = false;
  Vec3 previous_{0.0f};
  CellMask unknown_;  // cells of which the point before told nothing that holds for its neighbours

  struct Blockers {
    std::vector<float> x, y, z;  // padded for the kernel
    size_t count = 0;

    void Add(Vec3 p);
  } blockers_;
  std::vector<int32_t> part_;  // that each blocker hides
  std::vector<uint16_t> cell_of_part_;
  std::vector<uint8_t> taken_;  // 1 for each part that a blocker is kept for
  uint32_t turn_ = 0;           // of points since the start
  static constexpr size_t kMaxCells = size_t{CellMask::kMaxSide} * CellMask::kMaxSide;
  std::array<float, kMaxCells> x_, y_, z_, blocked_at_;  // rays
  std::array<uint32_t, kMaxCells> cells_;
};

}  // namespace penumbra
