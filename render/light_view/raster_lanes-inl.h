// The edges of triangles on an image, and the pixels between them, compiled once for each
// instruction set.

#if defined(PENUMBRA_RASTER_LANES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef PENUMBRA_RASTER_LANES_INL_H_
#undef PENUMBRA_RASTER_LANES_INL_H_
#else
#define PENUMBRA_RASTER_LANES_INL_H_
#endif

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "hwy/highway.h"
#include "render/light_view/raster_kernel.h"

HWY_BEFORE_NAMESPACE();
namespace penumbra {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using F = hn::CappedTag<float, kRasterLanes>;
using VF = hn::Vec<F>;
using F1 = hn::CappedTag<float, 1>;

// The line through two corners. Both triangles beside an edge compute the same number for a point,
// but for its sign, so that no point is outside of both.
struct Edge {
  float x, y, dx, dy;

  HWY_INLINE Edge(Vec2 a, Vec2 b) {
    const bool is_turned = b.x < a.x || (b.x == a.x && b.y < a.y);
    const float sign = is_turned ? -1.0f : 1.0f;
    x = is_turned ? b.x : a.x, y = is_turned ? b.y : a.y;
    dx = sign * ((is_turned ? a.x : b.x) - x), dy = sign * ((is_turned ? a.y : b.y) - y);
  }
};

// (py − y)·dx − (px − x)·dy along a row: ≥ 0 on the left of the line from the first corner to the
// second, x to the right and y up.
template <class D>
struct EdgeInRow {
  hn::Vec<D> x, dy, start;

  HWY_INLINE EdgeInRow(const Edge& e, float py)
      : x(hn::Set(D(), e.x)), dy(hn::Set(D(), e.dy)), start(hn::Set(D(), (py - e.y) * e.dx)) {}
  HWY_INLINE hn::Vec<D> At(hn::Vec<D> px) const { return hn::NegMulAdd(hn::Sub(px, x), dy, start); }
};

// The pixels whose centres lie in a triangle's box: first column and row, last column and row.
struct PixelBox {
  HWY_ALIGN int32_t sides[4];

  HWY_INLINE int32_t first_x() const { return sides[0]; }
  HWY_INLINE int32_t first_y() const { return sides[1]; }
  HWY_INLINE int32_t last_x() const { return sides[2]; }
  HWY_INLINE int32_t last_y() const { return sides[3]; }
};

// Of a row, the columns that an edge may leave, with a pixel to spare: more than rounding makes.
struct Span {
  float first, last;

  HWY_INLINE void CutBy(const Edge& e, float py) {
    const float x = e.x + (py - e.y) * e.dx / e.dy;  // where the edge crosses the row
    if (e.dy > 0) last = std::min(last, x + 0.5f);
    if (e.dy < 0) first = std::max(first, x - 1.5f);
  }
};

// What there is to do for a triangle.
enum class Coverage { kUnplaced, kNone, kOnePixel, kSome };

// Finds the pixels of the box around three corners. The sides of a box, (first x, first y, −last x,
// −last y), are the least of all corners' and the image's.
#if HWY_TARGET == HWY_SCALAR
HWY_INLINE Coverage CoverageOf(const RasterVertices& v, const uint16_t* corners, const float* image,
                               PixelBox& box) {
  float pixels[4];
  for (int k = 0; k < 4; ++k) {
    const auto side = [&](int corner) { return v.corners[4 * size_t{corners[corner]} + k]; };
    const float least = std::min(side(0), std::min(side(1), side(2)));
    if (!(least >= -kMaxReach)) return Coverage::kUnplaced;
    pixels[k] = std::max(std::ceil(least + (k < 2 ? -0.5f : 0.5f)), image[k]);
  }
  const float across = pixels[0] + pixels[2], down = pixels[1] + pixels[3];
  if (across > 0 || down > 0) return Coverage::kNone;
  for (int k = 0; k < 4; ++k) {
    box.sides[k] = static_cast<int32_t>(k < 2 ? pixels[k] : -pixels[k]);
  }
  return across == 0 && down == 0 ? Coverage::kOnePixel : Coverage::kSome;
}
#else
HWY_INLINE Coverage CoverageOf(const RasterVertices& v, const uint16_t* corners, const float* image,
                               PixelBox& box) {
  const hn::FixedTag<float, 4> f;
  const hn::RebindToSigned<decltype(f)> i;
  HWY_ALIGN static constexpr float kToCentres[4] = {-0.5f, -0.5f, 0.5f, 0.5f};
  const auto of = [&](int k) { return hn::Load(f, v.corners + 4 * size_t{corners[k]}); };
  const auto least = hn::Min(of(0), hn::Min(of(1), of(2)));
  if (!hn::AllTrue(f, hn::Ge(least, hn::Set(f, -kMaxReach)))) return Coverage::kUnplaced;
  const auto pixels =
      hn::Max(hn::Ceil(hn::Add(least, hn::Load(f, kToCentres))), hn::Load(f, image));
  const auto spread = hn::Add(pixels, hn::Shuffle1032(pixels));  // first − last, twice
  if (!hn::AllTrue(f, hn::Le(spread, hn::Zero(f)))) return Coverage::kNone;
  hn::Store(hn::ConvertTo(i, pixels), i, box.sides);
  box.sides[2] = -box.sides[2], box.sides[3] = -box.sides[3];
  return hn::AllTrue(f, hn::Eq(spread, hn::Zero(f))) ? Coverage::kOnePixel : Coverage::kSome;
}
#endif

}  // namespace HWY_NAMESPACE
}  // namespace penumbra
HWY_AFTER_NAMESPACE();

#endif  // toggled for each target
