#include "render/light_view/gl_depth_source.h"

#include <algorithm>
#include <deque>
#include <utility>

namespace penumbra {
namespace {

// The most pixels that are drawn and read at a time, unless a row has more: 16 MB.
constexpr uint32_t kBandPixels = 1u << 22;

// Bands that are drawn before the first of them is waited for: enough to keep the device busy.
constexpr size_t kBandsInFlight = 4;

// The share of its largest coordinate by which a box is made larger: its corners are rounded on
// their way into the world, and so are the vertices.
constexpr float kRounding = 0x1.0p-20f;

Aabb Roomy(const Aabb& box) {
  const Vec3 most = glm::max(glm::abs(box.min), glm::abs(box.max));
  const float margin = kRounding * std::max({most.x, most.y, most.z});
  return {.min = box.min - margin, .max = box.max + margin};
}

// Pixels of one view on their way.
struct Band {
  size_t view;
  RowBand rows;
  gl::Readback pixels;
};

// Takes bands in and gives maps out, in the order of the views.
class MapAssembly {
 public:
  MapAssembly(std::span<const LightView> views, const DepthSource::Take& take)
      : views_(views), take_(take) {}

  // The rows of band.view follow those that came before.
  absl::Status Add(const Band& band, std::span<const float> pixels) {
    const LightView& view = views_[band.view];
    if (band.rows.first == 0) {
      map_ = {.view = view};
      map_.depths.reserve(size_t{view.width} * view.height);
    }
    for (const float nearest : pixels) {
      const bool is_unseen = nearest <= DepthRenderer::kUnseen;
      const float depth = view.from_infinity ? -nearest : 1.0f / nearest;
      map_.depths.push_back(is_unseen ? kNoDepth : depth);
    }
    if (band.rows.first + band.rows.count < view.height) return absl::OkStatus();
    return take_(band.view, std::move(map_));
  }

 private:
  const std::span<const LightView> views_;
  const DepthSource::Take& take_;
  DepthMap map_;
};

}  // namespace

GlDepthSource::GlDepthSource(const Scene& scene, gl::Context& context, std::string field)
    : context_(context), field_(std::move(field)) {
  for (const auto& [id, instance] : scene.instances()) {
    if (!instance->casts || instance->mesh->triangle_count() == 0) continue;
    casters_.push_back({instance, Roomy(WorldBounds(*instance))});
  }
}

absl::Status GlDepthSource::Draw(std::span<const LightView> views, const std::stop_token& stop,
                                 const Take& take) {
  if (absl::Status status = CheckViews(views); !status.ok()) return status;
  auto renderer = DepthRenderer::Of(context_);
  if (!renderer.ok()) return renderer.status();
  (*renderer)->Begin(context_);
  MapAssembly maps(views, take);
  std::deque<Band> in_flight;
  const auto land = [&](size_t most) -> absl::Status {
    while (in_flight.size() > most) {
      if (stop.stop_requested()) return absl::CancelledError("stop requested");
      auto pixels = in_flight.front().pixels.Wait(context_);
      if (!pixels.ok()) return pixels.status();
      absl::Status status = maps.Add(in_flight.front(), *pixels);
      if (!status.ok()) return status;
      in_flight.pop_front();
    }
    return absl::OkStatus();
  };
  for (size_t i = 0; i < views.size(); ++i) {
    const LightView& view = views[i];
    if (stop.stop_requested()) return absl::CancelledError("stop requested");
    if (view.empty()) {
      if (absl::Status status = land(0); !status.ok()) return status;
      absl::Status status = take(i, NothingSeen(view));
      if (!status.ok()) return status;
      continue;
    }
    const uint32_t most_rows = std::max(1u, kBandPixels / view.width);
    for (uint32_t row = 0; row < view.height; row += most_rows) {
      const RowBand rows{row, std::min(most_rows, view.height - row)};
      auto pixels = (*renderer)->Draw(context_, casters_, view, rows, field_, stop);
      if (!pixels.ok()) return pixels.status();
      in_flight.push_back({i, rows, *std::move(pixels)});
      if (absl::Status status = land(kBandsInFlight - 1); !status.ok()) return status;
    }
  }
  return land(0);
}

}  // namespace penumbra
