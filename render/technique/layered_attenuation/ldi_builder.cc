#include "render/technique/layered_attenuation/ldi_builder.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "render/math/parallel_for.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

// What of a band and of as many maps is worked on at a time stays in a core's cache.
constexpr uint32_t kBandRows = 16;

// Of a nearness, what rounding may do to it before it is compared: at least eight of single
// precision's steps. Layers more than two apart have different depths.
constexpr double kRounding = 0x1.0p-20;

// kRounding in pixels' widths.
float LeastTolerance(const LightView& center, float pixel_width) {
  const double scale =
      center.from_infinity ? std::max(std::abs(center.near), std::abs(center.far)) : 1.0;
  return static_cast<float>(kRounding * scale / pixel_width);
}

uint32_t BlocksOf(uint32_t rows) { return (rows + kBandRows - 1) / kBandRows; }

}  // namespace

absl::Status CheckLdiBytes(size_t bytes, size_t most) {
  if (bytes <= most) return absl::OkStatus();
  return FieldError(absl::StatusCode::kResourceExhausted, "QUOTA_LDI_BYTES", "resolution",
                    absl::StrCat("found one at which layers and maps take ", bytes,
                                 " bytes, need at most ", most));
}

LdiBuilder::LdiBuilder(const LightView& center, float tolerance, const LdiLimits& limits,
                       std::shared_ptr<LdiUse> use)
    : center_(center),
      pixel_width_(static_cast<float>(
          1.0 / std::min(center.pixels_per_slope().x, center.pixels_per_slope().y))),
      tolerance_{.pixels = std::max(tolerance, LeastTolerance(center, pixel_width_)),
                 .width = pixel_width_},
      limits_(limits),
      use_(std::move(use)) {
  for (uint32_t row = 0; row < center.height; row += kBandRows) {
    bands_.emplace_back(center.width, row, std::min(kBandRows, center.height - row));
    use_->bytes += bands_.back().bytes();
  }
}

std::vector<LdiBuilder::Map> LdiBuilder::MapsOf(std::vector<DepthMap> depth_maps) const {
  std::vector<std::optional<Map>> made(depth_maps.size());
  ParallelFor(depth_maps.size(), [&](size_t m) {
    const ViewWarp warp(center_, depth_maps[m].view);
    const size_t pixels = depth_maps[m].depths.size();
    made[m] = Map{.seen = NearnessMap(std::move(depth_maps[m])),
                  .warp = warp,
                  .explained = std::vector<uint8_t>(pixels + 1),
                  .unexplained = {},
                  .lease = LdiLease(use_, pixels * kBytesPerPixel)};
  });
  std::vector<Map> maps;
  for (auto& map : made) maps.push_back(*std::move(map));
  return maps;
}

LdiBuilder::Unexplained LdiBuilder::FindUnexplained(const Map& map, uint32_t block) const {
  const NearnessMap& seen = map.seen;
  const ViewWarp& warp = map.warp;
  Unexplained found{.surfaces = {}, .first_row = center_.height, .end_row = 0};
  const Vec2 size(static_cast<float>(center_.width), static_cast<float>(center_.height));
  const uint32_t end_row = std::min(seen.view.height, (block + 1) * kBandRows);
  for (uint32_t y = block * kBandRows; y < end_row; ++y) {
    const uint8_t* const explained = &map.explained[size_t{y} * seen.view.width];
    const float* const row = seen.Row(y);
    for (uint32_t x = 0; x < seen.view.width; ++x) {
      if (explained[x] || row[x] == seen.nothing()) continue;
      const Vec2 at = Vec2(static_cast<float>(x), static_cast<float>(y)) + 0.5f - warp.view_origin;
      const Vec2 place = warp.ToCenter(at, row[x]) + warp.center_origin;
      if (!(place.x >= 0 && place.y >= 0 && place.x < size.x && place.y < size.y)) continue;
      const Vec2 pixel = PixelAt(place);
      const ImagePlane there{.at = at, .nearness = row[x], .gradient = GradientAt(seen, x, y)};
      const ImagePlane here =
          WithoutCliffs(warp.ToCenter(there), pixel_width_, seen.view.from_infinity);
      const Vec2 middle = pixel + 0.5f - warp.center_origin;
      const float nearness = here.At(middle);
      if (!center_.from_infinity && !(nearness > 0)) continue;
      const auto in_row = static_cast<uint32_t>(pixel.y);
      found.first_row = std::min(found.first_row, in_row);
      found.end_row = std::max(found.end_row, in_row + 1);
      found.surfaces.push_back({.column = static_cast<uint32_t>(pixel.x),
                                .row = in_row,
                                .plane = {middle, nearness, here.gradient}});
    }
  }
  return found;
}

void LdiBuilder::Add(std::span<const Unexplained> unexplained, LayerBand& band) {
  for (const Unexplained& some : unexplained) {
    if (some.end_row <= band.first_row() || some.first_row >= band.end_row()) continue;
    for (const PixelSurface& surface : some.surfaces) {
      if (surface.row < band.first_row() || surface.row >= band.end_row()) continue;
      const auto found = band.Add(surface, tolerance_, center_.from_infinity, limits_.max_layers);
      if (found == LayerBand::Found::kTooMany) too_many_ = true;
    }
  }
}

void LdiBuilder::Discover(std::span<Map> maps, const std::stop_token& stop) {
  const auto blocks_of = [](const Map& map) { return BlocksOf(map.seen.view.height); };
  size_t most = 0;
  for (Map& map : maps) {
    map.unexplained.assign(blocks_of(map), {});
    most = std::max<size_t>(most, blocks_of(map));
  }
  ParallelFor(most * maps.size(), [&](size_t i) {
    Map& map = maps[i / most];
    const auto block = static_cast<uint32_t>(i % most);
    if (block < blocks_of(map)) map.unexplained[block] = FindUnexplained(map, block);
  });
  for (Map& map : maps) {
    size_t bytes = map.explained.size() * kBytesPerPixel;
    for (const Unexplained& some : map.unexplained) {
      bytes += some.surfaces.capacity() * sizeof(PixelSurface);
    }
    map.lease.Resize(bytes);
  }
  ParallelFor(bands_.size(), [&](size_t b) {
    const size_t bytes = bands_[b].bytes();
    for (const Map& map : maps) {
      if (!Outcome(stop).ok()) return;
      Add(map.unexplained, bands_[b]);
    }
    use_->bytes += bands_[b].bytes() - bytes;
  });
}

void LdiBuilder::Count(std::span<const size_t> known, std::span<Map> maps,
                       const std::stop_token& stop) {
  std::vector<LookupMap> lookups;
  for (Map& map : maps) {
    const LightView& view = map.seen.view;
    lookups.push_back({.warp = map.warp,
                       .nearness = map.seen.nearness.data(),
                       .width = static_cast<int32_t>(view.width),
                       .height = static_cast<int32_t>(view.height),
                       .from_infinity = view.from_infinity,
                       .explained = map.explained.empty() ? nullptr : map.explained.data()});
  }
  ParallelFor(bands_.size(), [&](size_t b) {
    if (stop.stop_requested() || bands_[b].size() == known[b]) return;
    CountVisible(bands_[b].LayersFrom(known[b]), lookups, tolerance_);
  });
}

void LdiBuilder::Keep(std::span<Map> maps) {
  for (Map& map : maps) {
    const size_t bytes = map.seen.nearness.size() * sizeof(float);
    if (kept_bytes_ + bytes > limits_.max_kept_bytes) break;
    kept_bytes_ += bytes;
    map.lease.Resize(bytes);
    map.explained = {};
    map.unexplained = {};
    kept_.push_back(std::move(map));
  }
}

absl::Status LdiBuilder::Outcome(const std::stop_token& stop) const {
  if (stop.stop_requested()) return absl::CancelledError("stopped");
  if (too_many_) {
    return FieldError(absl::StatusCode::kResourceExhausted, "QUOTA_LDI_LAYERS", "max_layers",
                      absl::StrCat("found ", limits_.max_layers + 1,
                                   " layers at a pixel, need at most ", limits_.max_layers));
  }
  return CheckLdiBytes(use_->bytes, limits_.max_bytes);
}

template <typename Work>
absl::Status LdiBuilder::WorkOn(std::vector<DepthMap> depth_maps, tbb::task_arena& arena,
                                const std::stop_token& stop, const Work& work) {
  absl::Status status;
  RunIn(arena, [&] {
    std::vector<Map> maps = MapsOf(std::move(depth_maps));
    status = Outcome(stop);
    if (!status.ok()) return;
    work(std::span(maps));
    status = Outcome(stop);  // with the maps, which are no longer in use then
  });
  return status;
}

absl::Status LdiBuilder::AddSurfaces(DepthMap map, tbb::task_arena& arena,
                                     const std::stop_token& stop) {
  std::vector<DepthMap> one;
  one.push_back(std::move(map));
  return WorkOn(std::move(one), arena, stop, [&](std::span<Map> maps) { Discover(maps, stop); });
}

absl::Status LdiBuilder::InsertKnown(std::vector<DepthMap> depth_maps, tbb::task_arena& arena,
                                     const std::stop_token& stop) {
  return WorkOn(std::move(depth_maps), arena, stop, [&](std::span<Map> maps) {
    sample_count_ += static_cast<uint32_t>(maps.size());
    Count(std::vector<size_t>(bands_.size()), maps, stop);
  });
}

absl::Status LdiBuilder::Insert(std::vector<DepthMap> depth_maps, tbb::task_arena& arena,
                                const std::stop_token& stop) {
  if (depth_maps.empty()) return Outcome(stop);
  return WorkOn(std::move(depth_maps), arena, stop, [&](std::span<Map> maps) {
    sample_count_ += static_cast<uint32_t>(maps.size());
    if (layer_count() == 0) Discover(maps.first(1), stop);
    Count(std::vector<size_t>(bands_.size()), maps, stop);
    std::vector<size_t> known;
    for (const LayerBand& band : bands_) known.push_back(band.size());
    Discover(maps, stop);
    Count(known, kept_, stop);
    Count(known, maps, stop);
    if (Outcome(stop).ok()) Keep(maps);
  });
}

size_t LdiBuilder::layer_count() const {
  size_t count = 0;
  for (const LayerBand& band : bands_) count += band.size();
  return count;
}

LdiFace LdiBuilder::Finish() const {
  LdiFace face{.view = center_};
  face.offsets.reserve(size_t{center_.width} * center_.height + 1);
  face.depths.reserve(layer_count());
  face.counts.reserve(layer_count());
  for (const LayerBand& band : bands_) {
    band.Append(center_.from_infinity, static_cast<uint16_t>(unhidden_), face);
  }
  face.offsets.push_back(static_cast<uint32_t>(face.depths.size()));
  return face;
}

}  // namespace penumbra
