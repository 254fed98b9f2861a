#include "render/technique/shadow_width/distance_exact.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <utility>

#include "render/math/parallel_for.h"
#include "render/technique/shadow_width/distance_kernel.h"

namespace penumbra {
namespace {

// Rows of a strip: few enough for all threads to have work in small masks, and for a strip of 2048
// texels to stay in a core's cache.
constexpr uint32_t kStripRows = 32;

// For each strip one entry a column.
class ColumnEnds {
 public:
  ColumnEnds(uint32_t width, uint32_t strips)
      : width_(width), values_(size_t{width} * strips, kNoneLit) {}
  std::span<int16_t> operator[](uint32_t strip) {
    return {values_.data() + size_t{width_} * strip, width_};
  }

 private:
  size_t width_;
  std::vector<int16_t> values_;
};

class Strips {
 public:
  explicit Strips(const BlockedMask& mask)
      : mask_(mask),
        count_((mask.height + kStripRows - 1) / kStripRows),
        first_(mask.width, count_),
        last_(mask.width, count_),
        above_(mask.width, count_),
        below_(mask.width, count_) {}

  uint32_t count() const { return count_; }

  MaskStrip operator[](uint32_t strip) const {
    const uint32_t row = strip * kStripRows;
    return {mask_.blocked.data() + size_t{row} * mask_.width, mask_.width,
            std::min(kStripRows, mask_.height - row)};
  }

  void FindEnds(uint32_t strip) { FindLitEnds((*this)[strip], first_[strip], last_[strip]); }

  void Carry() {
    for (uint32_t s = 1; s < count_; ++s) {
      CarryEnds(last_[s - 1], above_[s - 1], (*this)[s - 1].rows, above_[s]);
    }
    for (uint32_t s = count_ - 1; s > 0; --s) {
      CarryEnds(first_[s], below_[s], (*this)[s].rows, below_[s - 1]);
    }
  }

  // After Carry().
  bool HasLit() {
    const auto is_some = [](int16_t distance) { return distance != kNoneLit; };
    return std::ranges::any_of(first_[0], is_some) || std::ranges::any_of(below_[0], is_some);
  }

  void Measure(uint32_t strip, float* distances) {
    MeasureStrip((*this)[strip], above_[strip], below_[strip],
                 distances + size_t{strip} * kStripRows * mask_.width);
  }

 private:
  const BlockedMask mask_;
  const uint32_t count_;
  ColumnEnds first_, last_, above_, below_;
};

}  // namespace

absl::StatusOr<std::vector<float>> DistanceToLit(const BlockedMask& mask, tbb::task_arena& arena,
                                                 const std::stop_token& stop,
                                                 std::vector<float> reused) {
  if (absl::Status status = CheckMask(mask); !status.ok()) return status;
  std::vector<float> distances = std::move(reused);
  distances.resize(size_t{mask.width} * mask.height);
  Strips strips(mask);
  std::atomic<bool> is_stopped = false;
  const auto unless_stopped = [&](const auto& work) {
    return [&](uint32_t strip) {
      if (stop.stop_requested()) is_stopped = true;
      if (!is_stopped) work(strip);
    };
  };
  RunIn(arena, [&] {
    ParallelFor(strips.count(), unless_stopped([&](uint32_t strip) { strips.FindEnds(strip); }));
    if (is_stopped) return;
    strips.Carry();
    if (!strips.HasLit()) {
      std::ranges::fill(distances, std::numeric_limits<float>::infinity());
      return;
    }
    ParallelFor(strips.count(),
                unless_stopped([&](uint32_t strip) { strips.Measure(strip, distances.data()); }));
  });
  if (is_stopped) return absl::CancelledError("stop requested");
  return distances;
}

}  // namespace penumbra
