#include "render/technique/shadow_width/distance_steps_cpu.h"

#include <algorithm>
#include <limits>
#include <span>
#include <utility>

#include "render/math/parallel_for.h"

namespace penumbra {
namespace {

struct Image {
  std::span<const float> texels;
  int width, height;

  std::span<const float> Row(int y) const {
    return texels.subspan(size_t{1} * width * std::clamp(y, 0, height - 1), width);
  }
};

// A row of distances, each with a step of the same offset and length as another way.
void StepRow(std::span<const float> from, const DistanceStep& step, std::span<float> least) {
  const auto width = static_cast<int>(least.size());
  const int dx = step.offset.x;
  const auto relax = [&](int x, int there) {
    least[x] = std::min(least[x], from[there] + step.length);
  };
  // Where the step stays in the row, and what it is on either side of that.
  const int begin = std::clamp(-dx, 0, width), end = std::clamp(width - dx, begin, width);
  for (int x = 0; x < begin; ++x) relax(x, 0);
  for (int x = begin; x < end; ++x) relax(x, x + dx);
  for (int x = end; x < width; ++x) relax(x, width - 1);
}

}  // namespace

absl::StatusOr<std::vector<float>> DistanceByStepsOnCpu(const BlockedMask& mask,
                                                        StepNeighbours neighbours,
                                                        tbb::task_arena& arena,
                                                        const std::stop_token& stop) {
  if (absl::Status status = CheckMask(mask); !status.ok()) return status;
  const int width = static_cast<int>(mask.width), height = static_cast<int>(mask.height);
  std::vector<float> distances(mask.blocked.size());
  std::ranges::transform(mask.blocked, distances.begin(), [](uint8_t blocked) {
    return blocked ? std::numeric_limits<float>::infinity() : 0.0f;
  });
  std::vector<float> next(distances.size());
  for (int size = 1; size < std::max(width, height); size *= 2) {
    const std::vector<DistanceStep> steps = StepsOf(neighbours, size);
    const Image before{distances, width, height};
    RunIn(arena, [&] {
      ParallelFor(height, [&](int y) {
        if (stop.stop_requested()) return;
        const std::span<float> least(next.data() + size_t{1} * width * y, width);
        std::ranges::copy(before.Row(y), least.begin());
        for (const DistanceStep& step : steps) {
          StepRow(before.Row(y + step.offset.y), step, least);
        }
      });
    });
    if (stop.stop_requested()) return absl::CancelledError("stop requested");
    std::swap(distances, next);
  }
  if (stop.stop_requested()) return absl::CancelledError("stop requested");
  return distances;
}

}  // namespace penumbra
