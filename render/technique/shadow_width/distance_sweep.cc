#include "render/technique/shadow_width/distance_sweep.h"

#include <algorithm>
#include <limits>

#include "render/math/parallel_for.h"

namespace penumbra {
namespace {

// Ways are counted in parts of a texel, so that sums are exact. The longest one, of kMaxMaskSide
// diagonals, fits 31 bits.
constexpr int32_t kStraight = 1 << 16;
constexpr int32_t kDiagonal = 92682;  // √2 · 2¹⁶, rounded up: no way is shorter than it is

// So far that no sum overflows.
constexpr int32_t kNowhere = std::numeric_limits<int32_t>::max() - kDiagonal;

// From left and right.
void SweepRow(const uint8_t* blocked, uint32_t width, int32_t* ways) {
  int32_t way = kNowhere;
  for (uint32_t x = 0; x < width; ++x) {
    way = blocked[x] ? std::min(way + kStraight, kNowhere) : 0;
    ways[x] = way;
  }
  for (uint32_t x = width; x-- > 0;) {
    way = std::min(ways[x], way + kStraight);
    ways[x] = way;
  }
}

// From one row to the next, above or below it. `from` has a texel more at either end, of kNowhere.
void SweepAcross(SweepNeighbours neighbours, const std::vector<int32_t>& from, uint32_t width,
                 int32_t* ways) {
  const int32_t* straight = from.data() + 1;
  if (neighbours == SweepNeighbours::kFour) {
    for (uint32_t x = 0; x < width; ++x) ways[x] = std::min(ways[x], straight[x] + kStraight);
    return;
  }
  const int32_t* left = from.data();
  const int32_t* right = from.data() + 2;
  for (uint32_t x = 0; x < width; ++x) {
    const int32_t diagonal = std::min(left[x], right[x]) + kDiagonal;
    ways[x] = std::min(ways[x], std::min(straight[x] + kStraight, diagonal));
  }
}

// Sideways first: any way can be put in the order sideways, then up or down and diagonally, and
// stays within the mask.
class Sweeps {
 public:
  Sweeps(const BlockedMask& mask, SweepNeighbours neighbours, const std::stop_token& stop)
      : mask_(mask),
        neighbours_(neighbours),
        stop_(stop),
        ways_(size_t{mask.width} * mask.height),
        from_(size_t{mask.width} + 2, kNowhere) {}

  void SweepSideways(tbb::task_arena& arena) {
    RunIn(arena, [&] {
      ParallelFor(mask_.height, [&](uint32_t y) {
        if (!stop_.stop_requested()) {
          SweepRow(mask_.blocked.data() + size_t{y} * mask_.width, mask_.width, Row(y));
        }
      });
    });
  }

  void SweepDownAndUp() {
    for (uint32_t y = 1; y < mask_.height && !stop_.stop_requested(); ++y) Sweep(y - 1, y);
    for (uint32_t y = mask_.height - 1; y > 0 && !stop_.stop_requested(); --y) Sweep(y, y - 1);
  }

  std::vector<float> Distances() const {
    std::vector<float> distances(ways_.size());
    std::transform(ways_.begin(), ways_.end(), distances.begin(), [](int32_t way) {
      return way == kNowhere ? std::numeric_limits<float>::infinity()
                             : static_cast<float>(way) * (1.0f / kStraight);
    });
    return distances;
  }

 private:
  int32_t* Row(uint32_t y) { return ways_.data() + size_t{y} * mask_.width; }

  void Sweep(uint32_t from, uint32_t to) {
    std::copy_n(Row(from), mask_.width, from_.begin() + 1);
    SweepAcross(neighbours_, from_, mask_.width, Row(to));
  }

  const BlockedMask mask_;
  const SweepNeighbours neighbours_;
  const std::stop_token& stop_;
  std::vector<int32_t> ways_;
  std::vector<int32_t> from_;
};

}  // namespace

absl::StatusOr<std::vector<float>> DistanceBySweeps(const BlockedMask& mask,
                                                    SweepNeighbours neighbours,
                                                    tbb::task_arena& arena,
                                                    const std::stop_token& stop) {
  if (absl::Status status = CheckMask(mask); !status.ok()) return status;
  Sweeps sweeps(mask, neighbours, stop);
  sweeps.SweepSideways(arena);
  sweeps.SweepDownAndUp();
  if (stop.stop_requested()) return absl::CancelledError("stop requested");
  return sweeps.Distances();
}

}  // namespace penumbra
