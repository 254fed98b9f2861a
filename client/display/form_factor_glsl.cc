#include "client/display/form_factor_glsl.h"

#include <cmath>
#include <numbers>
#include <variant>

#include "render/gl/program.h"

namespace penumbra {
namespace {

// Sides of the polygon that a disc becomes where the horizon cuts it, as in
// render/math/form_factor.cc.
constexpr int kDiskSides = 96;

constexpr char kGlsl[] = R"glsl(
struct Light {
  vec4 a;
  vec4 b;
  vec4 c;
  vec4 emission;
};

// arctan t - t for t in [0, 0.4143], by its series; the first term left out is below 1e-7 of the sum.
float AtanMinus(float t) {
  float q = t * t;
  return t * q *
         (-1.0 / 3.0 + q * (1.0 / 5.0 + q * (-1.0 / 7.0 + q * (1.0 / 9.0 + q * (-1.0 / 11.0 + q / 13.0)))));
}

// The angle in [0, pi] whose sine and cosine are as y to x, y >= 0. The drivers' own atan is allowed to be,
// and is, a hundred times less exact. Halves the angle twice, which brings its tangent below 0.4143.
float AngleOf(float y, float x) {
  float r = length(vec2(x, y));
  if (r == 0.0) return 0.0;
  float half_tangent = y / (r + abs(x));
  float t = half_tangent / (1.0 + sqrt(1.0 + half_tangent * half_tangent));
  float angle = 4.0 * (t + AtanMinus(t));
  return x < 0.0 ? kPi - angle : angle;
}

// The term of one edge in Lambert's sum: the angle it fills, times the cosine of its plane to n.
float EdgeTerm(vec3 from, vec3 edge, vec3 n) {
  vec3 normal = cross(from, edge);
  float area = length(normal);
  return area == 0.0 ? 0.0 : AngleOf(area, dot(from, from + edge)) * dot(n, normal) / area;
}

// A polygon's sum as it is walked around, with what lies below the horizon left out. Places on the outline
// are kept from its own origin, not from the point, which may be far away.
struct Walk {
  vec3 origin;  // from the point
  float sum;
  bool is_cut;
  vec3 way_up;    // where the outline rises through the horizon
  vec3 way_down;  // where it sinks
};

void WalkEdge(inout Walk walk, vec3 from, vec3 edge, float from_height, float to_height, vec3 n) {
  if (from_height < 0.0 && to_height < 0.0) return;
  float start = 0.0, end = 1.0;
  if ((from_height < 0.0) != (to_height < 0.0)) {
    float crossing = from_height / (from_height - to_height);
    walk.is_cut = true;
    if (from_height < 0.0) {
      start = crossing;
      walk.way_up = from + crossing * edge;
    } else {
      end = crossing;
      walk.way_down = from + crossing * edge;
    }
  }
  walk.sum += EdgeTerm(walk.origin + (from + start * edge), (end - start) * edge, n);
}

float FormFactorOfWalk(Walk walk, vec3 n) {
  float closing = walk.is_cut ? EdgeTerm(walk.origin + walk.way_down, walk.way_up - walk.way_down, n) : 0.0;
  return min(1.0, abs(walk.sum + closing) / (2.0 * kPi));
}

float FormFactorOfPolygon4(vec3 r0, vec3 edge_u, vec3 edge_v, vec3 n) {
  vec3 across = edge_u + edge_v;
  vec4 height = dot(n, r0) + vec4(0.0, dot(n, edge_u), dot(n, across), dot(n, edge_v));
  Walk walk = Walk(r0, 0.0, false, vec3(0.0), vec3(0.0));
  WalkEdge(walk, vec3(0.0), edge_u, height.x, height.y, n);
  WalkEdge(walk, edge_u, edge_v, height.y, height.z, n);
  WalkEdge(walk, across, -edge_u, height.z, height.w, n);
  WalkEdge(walk, edge_v, -edge_v, height.w, height.x, n);
  return FormFactorOfWalk(walk, n);
}

// A disc that the horizon cuts: a polygon of the same area.
float FormFactorOfCutDisk(vec3 to_center, vec3 axis, float radius, vec3 n) {
  vec3 across = abs(axis.x) < 0.5 ? vec3(1.0, 0.0, 0.0) : vec3(0.0, 1.0, 0.0);
  vec3 s = normalize(cross(axis, across)) * (radius * kDiskGrowth);
  vec3 t = cross(axis, s);
  Walk walk = Walk(to_center, 0.0, false, vec3(0.0), vec3(0.0));
  float center_height = dot(n, to_center);
  vec2 turn = vec2(1.0, 0.0);
  vec3 from = s;
  float from_height = center_height + dot(n, from);
  for (int i = 1; i <= kDiskSides; ++i) {
    float angle = float(i % kDiskSides) * (2.0 * kPi / float(kDiskSides));
    vec2 next = vec2(cos(angle), sin(angle));
    vec3 to = next.x * s + next.y * t;
    float to_height = center_height + dot(n, to);
    WalkEdge(walk, from, (next.x - turn.x) * s + (next.y - turn.y) * t, from_height, to_height, n);
    turn = next;
    from = to;
    from_height = to_height;
  }
  return FormFactorOfWalk(walk, n);
}

// n . Phi, with the disc's flux along and across its axis; see form_factor.h.
float FormFactorOfWholeDisk(vec3 to_center, vec3 axis, float radius, vec3 n) {
  float along = dot(to_center, axis);
  vec3 across = to_center - along * axis;
  float z2 = along * along;
  float rho2 = dot(across, across);
  float rho = sqrt(rho2);
  float r2 = radius * radius;
  float sum = z2 + rho2 + r2;
  // 1 - q / root, where root * root - q * q = 4 r2 z2: far away q comes close to root.
  float q = z2 + (rho - radius) * (rho + radius);
  float root = length(vec2(q, 2.0 * abs(along) * radius));
  if (root == 0.0) return 0.0;  // on the rim
  float axial = q > 0.0 ? 2.0 * r2 * z2 / (root * (root + q)) : 0.5 * (1.0 - q / root);
  float radial_over_rho = 2.0 * r2 * abs(along) / (root * (sum + root));
  vec3 towards_plane = along < 0.0 ? -axis : axis;
  return clamp(axial * dot(n, towards_plane) + radial_over_rho * dot(n, across), 0.0, 1.0);
}

float FormFactorOfDisk(vec3 to_center, vec3 axis, float radius, vec3 n) {
  // |n x axis| is the sine of the tilt without the cancellation of 1 - cos * cos.
  float reach = radius * length(cross(n, axis));
  float height = dot(n, to_center);
  if (height <= -reach) return 0.0;
  if (height >= reach) return FormFactorOfWholeDisk(to_center, axis, radius, n);
  return FormFactorOfCutDisk(to_center, axis, radius, n);
}

// See CapFormFactor in form_factor.cc. With x = cut / cos alpha the last two of its terms are
// arctan x - x + x sin2 alpha, whose first two are small of third order together.
float FormFactorOfCap(float cos_to_axis, float sin2_alpha) {
  float sin_alpha = sqrt(sin2_alpha);
  if (cos_to_axis >= sin_alpha) return cos_to_axis * sin2_alpha;
  if (cos_to_axis <= -sin_alpha) return 0.0;
  float cos_alpha = sqrt(1.0 - sin2_alpha);
  float cut = sqrt(max(0.0, (sin_alpha - cos_to_axis) * (sin_alpha + cos_to_axis)));
  float ellipse = cos_to_axis * sin2_alpha * AngleOf(cut, -cos_to_axis * cos_alpha);
  float x = cut / max(cos_alpha, 1e-18);
  float rest = x < 0.4 ? AtanMinus(x) + x * sin2_alpha : AngleOf(cut, cos_alpha) - cos_alpha * cut;
  return clamp((ellipse + rest) / kPi, 0.0, 1.0);
}

// A surface that a light lies on does not see it: there rounding alone would say which side it is.
bool SeesEmittingSide(vec3 point, vec3 to_light, vec3 front, float two_sided) {
  float height = -dot(front, to_light);
  float rounding = 1e-5 * length(front) * (length(point) + length(to_light));
  return (two_sided != 0.0 ? abs(height) : height) > rounding;
}

float FactorOfSphere(vec3 to_center, float radius, vec3 n) {
  float distance2 = dot(to_center, to_center);
  float radius2 = radius * radius;
  if (distance2 <= radius2) return 1.0;
  return FormFactorOfCap(dot(n, to_center) * inversesqrt(distance2), radius2 / distance2);
}

float FactorOfPoint(vec3 to_light, vec3 n) {
  float distance2 = dot(to_light, to_light);
  if (distance2 == 0.0) return 0.0;
  return max(0.0, dot(n, to_light)) / (kPi * distance2 * sqrt(distance2));
}

float FactorOfSpot(Light light, vec3 to_light, vec3 n) {
  float distance = length(to_light);
  if (distance == 0.0) return 0.0;
  float cos_angle = -dot(light.b.xyz, to_light) / distance;
  float ramp = clamp((cos_angle - light.c.x) / max(1e-12, light.c.y - light.c.x), 0.0, 1.0);
  return ramp * ramp * FactorOfPoint(to_light, n);
}

float FactorOfDistant(Light light, vec3 n) {
  float cos_to_light = dot(n, light.a.xyz);
  float sin_alpha = light.b.w;
  if (sin_alpha < 1e-6) return max(0.0, cos_to_light) / kPi;
  float sin2_alpha = sin_alpha * sin_alpha;
  return FormFactorOfCap(cos_to_light, sin2_alpha) / (kPi * sin2_alpha);
}

float UnoccludedFactor(Light light, vec3 point, vec3 n) {
  vec3 to_light = light.a.xyz - point;
  switch (int(light.emission.w)) {
    case kRectangle:
      if (!SeesEmittingSide(point, to_light, cross(light.b.xyz, light.c.xyz), light.a.w)) return 0.0;
      return FormFactorOfPolygon4(to_light, light.b.xyz, light.c.xyz, n);
    case kDisk:
      if (!SeesEmittingSide(point, to_light, light.b.xyz, light.a.w)) return 0.0;
      return FormFactorOfDisk(to_light, light.b.xyz, light.b.w, n);
    case kSphere:
      return FactorOfSphere(to_light, light.b.w, n);
    case kPoint:
      return FactorOfPoint(to_light, n);
    case kSpot:
      return FactorOfSpot(light, to_light, n);
    default:
      return FactorOfDistant(light, n);
  }
}

vec3 UnoccludedRadiance(Light light, vec3 point, vec3 n) {
  return light.emission.rgb * UnoccludedFactor(light, point, n);
}
)glsl";

template <typename Shape, size_t I = 0>
constexpr int KindOf() {
  if constexpr (std::is_same_v<Shape, std::variant_alternative_t<I, LightShape>>) {
    return static_cast<int>(I);
  } else {
    return KindOf<Shape, I + 1>();
  }
}

template <typename Shape>
float Kind(const Shape&) {
  return static_cast<float>(KindOf<Shape>());
}

Vec3 Unit(Vec3 v) { return Vec3(glm::normalize(DVec3(v))); }

GpuLight Gpu(const RectangleLight& light) {
  return {.a = Vec4(light.corner, light.two_sided ? 1.0f : 0.0f),
          .b = Vec4(light.edge_u, 0),
          .c = Vec4(light.edge_v, 0),
          .emission = Vec4(light.radiance, Kind(light))};
}
GpuLight Gpu(const DiskLight& light) {
  return {.a = Vec4(light.center, light.two_sided ? 1.0f : 0.0f),
          .b = Vec4(Unit(light.normal), light.radius),
          .emission = Vec4(light.radiance, Kind(light))};
}
GpuLight Gpu(const SphereLight& light) {
  return {.a = Vec4(light.center, 0),
          .b = Vec4(0, 0, 0, light.radius),
          .emission = Vec4(light.radiance, Kind(light))};
}
GpuLight Gpu(const PointLight& light) {
  return {.a = Vec4(light.position, 0), .emission = Vec4(light.intensity, Kind(light))};
}
GpuLight Gpu(const SpotLight& light) {
  return {.a = Vec4(light.position, 0),
          .b = Vec4(Unit(light.direction), 0),
          .c = Vec4(std::cos(light.outer_angle), std::cos(light.inner_angle), 0, 0),
          .emission = Vec4(light.intensity, Kind(light))};
}
GpuLight Gpu(const DistantLight& light) {
  return {.a = Vec4(Unit(light.to_light), 0),
          .b = Vec4(0, 0, 0, std::sin(0.5f * light.angular_diameter)),
          .emission = Vec4(light.irradiance, Kind(light))};
}

}  // namespace

GpuLight ToGpu(const AreaLight& light) {
  return std::visit([](const auto& shape) { return Gpu(shape); }, light.shape);
}

std::string FormFactorGlsl() {
  const double step = 2 * std::numbers::pi / kDiskSides;
  return gl::GlslConstant("kPi", std::numbers::pi) + gl::GlslConstant("kDiskSides", kDiskSides) +
         gl::GlslConstant("kDiskGrowth", std::sqrt(step / std::sin(step))) +
         gl::GlslConstant("kRectangle", KindOf<RectangleLight>()) +
         gl::GlslConstant("kDisk", KindOf<DiskLight>()) +
         gl::GlslConstant("kSphere", KindOf<SphereLight>()) +
         gl::GlslConstant("kPoint", KindOf<PointLight>()) +
         gl::GlslConstant("kSpot", KindOf<SpotLight>()) + kGlsl;
}

}  // namespace penumbra
