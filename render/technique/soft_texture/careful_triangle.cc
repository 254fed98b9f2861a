#include "render/technique/soft_texture/careful_triangle.h"

#include <algorithm>
#include <cmath>

namespace penumbra {
namespace {

// Below this w a point is taken to be level with the light, where its shadow goes to infinity. A
// lamp's glowing face lies in the light itself: rounding puts it a few 2⁻²⁰ of the height before or
// behind a sample.
constexpr double kSmallestW = 0x1.0p-16;
constexpr double kMargin = 0.5;  // of the texture, kept on each side

using HomogeneousPolygon = std::array<DVec3, ClippedPolygon::kMaxCorners>;

// Cuts `polygon` by `inside` ≥ 0, linear in (x, y, w). Crossings are computed from the inner
// corner, so that neighbours agree.
// Source  Sutherland and Hodgman 1974
size_t Cut(HomogeneousPolygon& polygon, size_t size, DVec3 plane, double offset) {
  std::array<double, ClippedPolygon::kMaxCorners> inside;
  size_t in_count = 0;
  for (size_t i = 0; i < size; ++i) {
    inside[i] = glm::dot(plane, polygon[i]) - offset;
    in_count += inside[i] >= 0;
  }
  if (in_count == size) return size;
  if (in_count == 0) return 0;
  HomogeneousPolygon kept;
  size_t count = 0;
  for (size_t i = 0; i < size; ++i) {
    const size_t next = i + 1 < size ? i + 1 : 0;
    const bool from_is_in = inside[i] >= 0;
    if (from_is_in) kept[count++] = polygon[i];
    if (from_is_in == (inside[next] >= 0)) continue;
    const size_t in = from_is_in ? i : next, out = from_is_in ? next : i;
    kept[count++] =
        polygon[in] + (polygon[out] - polygon[in]) * (inside[in] / (inside[in] - inside[out]));
  }
  std::copy_n(kept.begin(), count, polygon.begin());
  return count;
}

struct Span {
  double left, right;
  bool empty = true;

  void Add(double x) {
    left = empty ? x : std::min(left, x);
    right = empty ? x : std::max(right, x);
    empty = false;
  }
};

// Where the polygon's edges meet a row.
Span SpanInRow(const ClippedPolygon& polygon, double row) {
  Span span{0, 0};
  for (size_t i = 0; i < polygon.size; ++i) {
    DVec2 low = polygon.texels[i], high = polygon.texels[(i + 1) % polygon.size];
    if (low.y > high.y) std::swap(low, high);
    if (row < low.y || row >= high.y) continue;
    span.Add(low.x + (row - low.y) * ((high.x - low.x) / (high.y - low.y)));
  }
  return span;
}

}  // namespace

ClippedPolygon ClipToTexture(const HomogeneousTriangle& triangle, double width, double height) {
  HomogeneousPolygon polygon;
  std::copy(triangle.begin(), triangle.end(), polygon.begin());
  size_t size = 3;
  const struct {
    DVec3 plane;
    double offset;
  } kCuts[] = {{{0, 0, 1}, kSmallestW},
               {{1, 0, kMargin}, 0},
               {{-1, 0, 1 + kMargin}, 0},
               {{0, 1, kMargin}, 0},
               {{0, -1, 1 + kMargin}, 0}};
  for (const auto& cut : kCuts) {
    size = Cut(polygon, size, cut.plane, cut.offset);
    if (size < 3) return {};
  }
  ClippedPolygon clipped;
  for (; clipped.size < size; ++clipped.size) {
    const DVec3& p = polygon[clipped.size];
    clipped.texels[clipped.size] = {width * p.x / p.z - 0.5, height * p.y / p.z - 0.5};
  }
  return clipped;
}

void FillPolygon(const ClippedPolygon& polygon, const TexelWindow& window,
                 const std::function<bool(uint32_t, uint32_t)>& opaque, ShadowBitmap& bitmap) {
  if (polygon.size < 3) return;
  const auto by_row = [](DVec2 a, DVec2 b) { return a.y < b.y; };
  const auto [lowest, highest] =
      std::minmax_element(polygon.texels.begin(), polygon.texels.begin() + polygon.size, by_row);
  const auto clamped_row = [&](double y) {
    return static_cast<uint32_t>(
        std::clamp<double>(std::ceil(y), window.row_begin, window.row_end));
  };
  const auto clamped_column = [&](double x) {
    return static_cast<uint32_t>(std::clamp<double>(std::ceil(x), 0, window.width));
  };
  const uint32_t row_end = clamped_row(highest->y);
  for (uint32_t row = clamped_row(lowest->y); row < row_end; ++row) {
    const Span span = SpanInRow(polygon, row);
    if (span.empty) continue;
    const uint32_t begin = clamped_column(span.left), end = clamped_column(span.right);
    if (begin >= end) continue;
    const uint32_t local_row = row - window.row_begin;
    for (uint32_t word = begin / 32; 32 * word < end; ++word) {
      const uint32_t first = std::max(begin, 32 * word), last = std::min(end, 32 * word + 32);
      uint32_t bits = 0;
      if (!opaque) bits = (~0u >> (32 - (last - first))) << (first % 32);
      for (uint32_t column = first; opaque && column < last; ++column) {
        if (opaque(column, row)) bits |= 1u << (column % 32);
      }
      bitmap.Column(word)[local_row] |= bits;
    }
    bitmap.Touch(begin / 32, (end + 31) / 32, local_row, local_row + 1);
  }
}

UvAcrossTriangle::UvAcrossTriangle(const HomogeneousTriangle& triangle,
                                   const std::array<Vec2, 3>& uv, double width, double height)
    : u_numerator_(0.0), v_numerator_(0.0), denominator_(0.0) {
  for (int k = 0; k < 3; ++k) {
    const DVec3 edge = glm::cross(triangle[(k + 1) % 3], triangle[(k + 2) % 3]);
    // (u, v, 1) in terms of (column, row, 1).
    const DVec3 in_texels(edge.x / width, edge.y / height,
                          0.5 * edge.x / width + 0.5 * edge.y / height + edge.z);
    denominator_ += in_texels;
    u_numerator_ += double{uv[k].x} * in_texels;
    v_numerator_ += double{uv[k].y} * in_texels;
  }
}

Vec2 UvAcrossTriangle::At(uint32_t column, uint32_t row) const {
  const DVec3 texel(column, row, 1);
  const double denominator = glm::dot(denominator_, texel);
  if (denominator == 0) return Vec2(0.0f);
  return Vec2(DVec2(glm::dot(u_numerator_, texel), glm::dot(v_numerator_, texel)) / denominator);
}

}  // namespace penumbra
