#include "render/light_view/gl/triangle_glsl.h"

#include "absl/strings/str_cat.h"
#include "render/gl/program.h"
#include "render/light_view/gl/mesh_store.h"

namespace penumbra {
namespace {

// Texels by which a triangle is made larger to be sure of its candidates: GL promises a grid of
// 1/16 of a texel, on which a vertex moves by half as much, and single precision far from the
// target adds less than that again.
constexpr double kMargin = 0.125;

constexpr char kCover[] = R"glsl(
double Cross(dvec2 a, dvec2 b) { return a.x * b.y - a.y * b.x; }

// Corner k of a triangle around a, b, c that leaves kMargin everywhere.
dvec2 LargerCorner(int k, dvec2 a, dvec2 b, dvec2 c) {
  dvec3 sides = dvec3(distance(b, c), distance(c, a), distance(a, b));
  double perimeter = sides.x + sides.y + sides.z;
  double inradius = perimeter > 0.0 ? abs(Cross(b - a, c - a)) / perimeter : 0.0;
  if (inradius >= 2.0 * kMargin) {
    dvec2 middle = (sides.x * a + sides.y * b + sides.z * c) / perimeter;
    dvec2 corner = k == 0 ? a : k == 1 ? b : c;
    return middle + (corner - middle) * (1.0 + kMargin / inradius);
  }
  // Too thin for that: half of the parallelogram that is twice as long and as high as the rectangle
  // along the longest side.
  dvec2 start = a, end = b, other = c;
  if (sides.x >= max(sides.y, sides.z)) {
    start = b; end = c; other = a;
  } else if (sides.y >= sides.z) {
    start = c; end = a; other = b;
  }
  double length_along = distance(start, end);
  dvec2 along = length_along > 0.0 ? (end - start) / length_along : dvec2(1.0, 0.0);
  dvec2 across = dvec2(-along.y, along.x);
  double height = dot(other - start, across);
  double low = min(0.0, height) - kMargin, high = max(0.0, height) + kMargin;
  dvec2 corner = start - kMargin * along + low * across;
  if (k == 1) corner += 2.0 * (length_along + 2.0 * kMargin) * along;
  if (k == 2) corner += 2.0 * (high - low) * across;
  return corner;
}

// False: no texel centre lies between the least and the greatest of the corners.
bool SpansCenters(dvec2 a, dvec2 b, dvec2 c) {
  const double kRounding = 1.0 / 1024.0;
  dvec2 least = min(min(a, b), c) - kRounding, greatest = max(max(a, b), c) + kRounding;
  return all(lessThanEqual(ceil(least), greatest));
}
)glsl";

// AlphaMask::At and its RepeatedTexel.
constexpr char kMask[] = R"glsl(
layout(binding = kMaskUnit) uniform usampler2D mask;
uniform int least_alpha;

int RepeatedTexel(float t, int count) {
  float wrapped = t - floor(t);
  if (!(wrapped >= 0.0)) return 0;
  return min(int(wrapped * float(count)), count - 1);
}

bool IsHoleAt(vec2 uv) {
  ivec2 mask_size = textureSize(mask, 0);
  ivec2 at = ivec2(RepeatedTexel(uv.x, mask_size.x), RepeatedTexel(uv.y, mask_size.y));
  return int(texelFetch(mask, at, 0).r) < least_alpha;
}
)glsl";

}  // namespace

std::string TriangleCoverGlsl() {
  return absl::StrCat(gl::GlslConstant("kMargin", kMargin), kCover);
}

std::string AlphaMaskGlsl() {
  return absl::StrCat(gl::GlslConstant("kMaskUnit", kMaskUnit), kMask);
}

}  // namespace penumbra
