#include "render/light_view/raster_depth_source.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "render/light_view/depth_raster.h"
#include "render/math/parallel_for.h"

namespace penumbra {
namespace {

// Widths of its window from straight ahead at which a view gets a frame that is sheared towards it:
// at 512 pixels a width, 2048 pixels off, rounding moves an edge by a thousandth of a pixel.
constexpr double kFarAside = 4.0;

// Pixels of the maps that are drawn at a time, unless one has more: 256 MB.
constexpr size_t kMostPixels = size_t{1} << 26;

// How many of the first of `views` are drawn at a time.
size_t AtOnce(std::span<const LightView> views, size_t threads) {
  size_t count = 0, pixels = 0;
  while (count < std::min(threads, views.size())) {
    pixels += size_t{views[count].width} * views[count].height;
    if (count > 0 && pixels > kMostPixels) break;
    ++count;
  }
  return count;
}

// The frame to draw `view` in. A function of the view alone, so that it is drawn alike in any
// company; most views of one face share one, for `middle` is coarse.
RasterFrame FrameFor(const LightView& view) {
  RasterFrame frame{view.frame};
  if (view.from_infinity || view.empty()) return frame;
  for (int axis = 0; axis < 2; ++axis) {
    const double middle = 0.5 * (view.window.min[axis] + view.window.max[axis]);
    const double size = view.window.size()[axis];
    if (std::abs(middle) <= kFarAside * size) continue;
    const double step = std::exp2(std::ceil(std::log2(kFarAside * size)));
    frame.middle[axis] = step * std::round(middle / step);
  }
  return frame;
}

bool operator==(const RasterFrame& a, const RasterFrame& b) {
  const Basis &p = a.frame.axes, &q = b.frame.axes;
  return a.frame.origin == b.frame.origin && p.s == q.s && p.t == q.t && p.n == q.n &&
         a.middle == b.middle;
}

}  // namespace

RasterDepthSource::RasterDepthSource(const Scene& scene, tbb::task_arena& arena) : arena_(arena) {
  for (const auto& [id, instance] : scene.instances()) {
    if (instance->casts && instance->mesh->triangle_count() > 0) casters_.push_back(instance);
  }
}

absl::Status RasterDepthSource::PlaceIn(const RasterFrame& frame, const std::stop_token& stop) {
  if (frame_ && *frame_ == frame) return absl::OkStatus();
  frame_.reset();
  placed_.clear();
  placed_.resize(casters_.size());
  RunIn(arena_, [&] {
    ParallelFor(casters_.size(), [&](size_t i) { placed_[i].emplace(frame, casters_[i], stop); });
  });
  if (stop.stop_requested()) return absl::CancelledError("stopped");
  frame_ = frame;
  return absl::OkStatus();
}

absl::Status RasterDepthSource::Draw(std::span<const LightView> views, const std::stop_token& stop,
                                     const Take& take) {
  if (absl::Status status = CheckViews(views); !status.ok()) return status;
  for (size_t first = 0; first < views.size();) {
    if (stop.stop_requested()) return absl::CancelledError("stopped");
    const RasterFrame frame = FrameFor(views[first]);
    size_t end = first + 1;
    while (end < views.size() && FrameFor(views[end]) == frame) ++end;
    if (absl::Status status = PlaceIn(frame, stop); !status.ok()) return status;
    absl::Status status = DrawPlaced(views.subspan(first, end - first), first, stop, take);
    if (!status.ok()) return status;
    first = end;
  }
  return absl::OkStatus();
}

absl::Status RasterDepthSource::DrawPlaced(std::span<const LightView> views, size_t first_index,
                                           const std::stop_token& stop, const Take& take) {
  const auto threads = static_cast<size_t>(arena_.max_concurrency());
  std::vector<std::optional<DepthMap>> maps(threads);
  for (size_t first = 0; first < views.size();) {
    const size_t count = AtOnce(views.subspan(first), threads);
    RunIn(arena_, [&] {
      ParallelFor(count, [&](size_t i) {
        DepthRaster raster(views[first + i], *frame_);
        for (const auto& caster : placed_) raster.Draw(*caster, stop);
        maps[i] = std::move(raster).Finish();
      });
    });
    for (size_t i = 0; i < count; ++i) {
      if (stop.stop_requested()) return absl::CancelledError("stopped");
      absl::Status status = take(first_index + first + i, *std::move(maps[i]));
      if (!status.ok()) return status;
    }
    first += count;
  }
  return absl::OkStatus();
}

}  // namespace penumbra
