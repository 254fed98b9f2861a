#include "render/scene/coverage_mask.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>

namespace penumbra {
namespace {

// One polygon at a time, row by row, by the even-odd rule.
class Filler {
 public:
  Filler(uint32_t width, uint32_t height)
      : size_(width, height), mask_(std::make_shared<CoverageMask>(width, height)) {}

  void Fill(std::span<const DVec2> polygon) {
    if (polygon.empty()) return;
    texels_.clear();
    double low = size_.y, high = 0;
    for (const DVec2& uv : polygon) {
      texels_.push_back(uv * size_);
      low = std::min(low, texels_.back().y);
      high = std::max(high, texels_.back().y);
    }
    const double first = std::max(0.0, std::ceil(low - 0.5 - kCoverageSlack));
    const double last = std::min(size_.y - 1, std::floor(high - 0.5 + kCoverageSlack));
    for (double row = first; row <= last; ++row) {
      // The rows a little below and above close what rounding opens between polygons.
      for (const double shift : {-kCoverageSlack, 0.0, kCoverageSlack}) {
        FillRow(static_cast<size_t>(row), row + 0.5 + shift);
      }
    }
  }

  std::shared_ptr<CoverageMask> Take() { return std::move(mask_); }

 private:
  void FillRow(size_t row, double y) {
    crossings_.clear();
    for (size_t i = 0; i < texels_.size(); ++i) {
      const DVec2 a = texels_[i], b = texels_[(i + 1) % texels_.size()];
      if ((a.y <= y) == (b.y <= y)) continue;
      crossings_.push_back(a.x + (y - a.y) * (b.x - a.x) / (b.y - a.y));
    }
    std::sort(crossings_.begin(), crossings_.end());
    for (size_t i = 0; i + 1 < crossings_.size(); i += 2) {
      const double first = std::max(0.0, std::ceil(crossings_[i] - 0.5 - kCoverageSlack));
      const double last =
          std::min(size_.x - 1, std::floor(crossings_[i + 1] - 0.5 + kCoverageSlack));
      for (double x = first; x <= last; ++x) {
        mask_->Set(row * static_cast<size_t>(size_.x) + static_cast<size_t>(x));
      }
    }
  }

  DVec2 size_;
  std::shared_ptr<CoverageMask> mask_;
  std::vector<DVec2> texels_;      // of the polygon
  std::vector<double> crossings_;  // of the row
};

// To the nearest texel inside.
struct Offset {
  static constexpr int8_t kNone = 127;
  int8_t x = kNone, y = 0;

  int LengthSquared() const { return x == kNone ? 1 << 20 : x * x + y * y; }
};

class DistanceSweeps {
 public:
  DistanceSweeps(const CoverageMask& mask, int reach)
      : width_(static_cast<int>(mask.width())),
        height_(static_cast<int>(mask.height())),
        reach_squared_(reach * reach),
        offsets_(mask.texel_count()) {
    for (size_t k = 0; k < offsets_.size(); ++k) {
      if (mask.At(k)) offsets_[k] = {0, 0};
    }
    for (int j = 0; j < height_; ++j) SweepRow(j, -1);
    for (int j = height_ - 1; j >= 0; --j) SweepRow(j, +1);
  }

  const std::vector<Offset>& offsets() const { return offsets_; }

 private:
  // Takes over what row j + dj found, then along the row both ways.
  void SweepRow(int j, int dj) {
    for (int i = 0; i < width_; ++i) {
      for (int di = -1; di <= 1; ++di) TakeOver(i, j, di, dj);
    }
    for (int i = 0; i < width_; ++i) TakeOver(i, j, -1, 0);
    for (int i = width_ - 1; i >= 0; --i) TakeOver(i, j, +1, 0);
  }
  void TakeOver(int i, int j, int di, int dj) {
    if (i + di < 0 || i + di >= width_ || j + dj < 0 || j + dj >= height_) return;
    const Offset from = offsets_[static_cast<size_t>(j + dj) * width_ + i + di];
    if (from.x == Offset::kNone) return;
    const int x = from.x + di, y = from.y + dj;
    Offset& to = offsets_[static_cast<size_t>(j) * width_ + i];
    const int length_squared = x * x + y * y;
    if (length_squared > reach_squared_ || length_squared >= to.LengthSquared()) return;
    to = {static_cast<int8_t>(x), static_cast<int8_t>(y)};
  }

  const int width_, height_, reach_squared_;
  std::vector<Offset> offsets_;
};

}  // namespace

size_t CoverageMask::CountInside() const {
  size_t count = 0;
  for (const uint8_t byte : bytes_) count += static_cast<size_t>(std::popcount(byte));
  return count;
}

std::shared_ptr<const CoverageMask> CoverRegion(const PlanarRegion& region, uint32_t width,
                                                uint32_t height) {
  Filler filler(width, height);
  size_t begin = 0;
  for (const uint32_t end : region.ends) {
    filler.Fill(std::span(region.points).subspan(begin, end - begin));
    begin = end;
  }
  auto mask = filler.Take();
  const size_t inside = mask->CountInside();
  if (inside == mask->texel_count() || mask->texel_count() == 1) return nullptr;
  if (inside == 0) {
    DVec2 middle(0.0);
    const size_t count = region.ends.empty() ? 0 : region.ends.front();
    for (size_t i = 0; i < count; ++i) middle += region.points[i] / static_cast<double>(count);
    const DVec2 texel = glm::clamp(glm::floor(middle * DVec2(width, height)), DVec2(0.0),
                                   DVec2(width - 1.0, height - 1.0));
    mask->Set(static_cast<size_t>(texel.y) * width + static_cast<size_t>(texel.x));
  }
  return mask;
}

std::vector<GutterTexel> FindGutter(const CoverageMask& mask, int reach) {
  const DistanceSweeps sweeps(mask, std::min(reach, 100));
  std::vector<GutterTexel> gutter;
  for (size_t k = 0; k < sweeps.offsets().size(); ++k) {
    const Offset offset = sweeps.offsets()[k];
    if (offset.x == Offset::kNone || offset.LengthSquared() == 0) continue;
    const auto inside = static_cast<int64_t>(k) + int64_t{offset.y} * mask.width() + offset.x;
    gutter.push_back({static_cast<uint32_t>(k), static_cast<uint32_t>(inside)});
  }
  return gutter;
}

}  // namespace penumbra
