#include "client/display/light_above_plane_glsl.h"

namespace penumbra {
namespace {

constexpr char kGlsl[] = R"glsl(
// The integral of clamp(x, 0, 1) from -infinity.
float ClampIntegral(float x) {
  if (x <= 0.0) return 0.0;
  return x < 1.0 ? 0.5 * x * x : x - 0.5;
}

// The share of the unit square where a + b s + c t > 0.
float SquareAbove(float a, float b, float c) {
  if (abs(b) < abs(c)) {
    float other = b;
    b = c;
    c = other;
  }
  if (b == 0.0) return a > 0.0 ? 1.0 : 0.0;
  if (b < 0.0) {
    a += b;
    b = -b;
  }
  float first = (a + b) / b, last = (a + b + c) / b, change = c / b;
  // Single precision loses the difference of the integrals sooner than the C++ does.
  if (abs(change) < 1e-3) return clamp(0.5 * (first + last), 0.0, 1.0);
  return clamp((ClampIntegral(last) - ClampIntegral(first)) / change, 0.0, 1.0);
}

float ArcSine(float x) { return 0.5 * kPi - AngleOf(sqrt(max(0.0, (1.0 - x) * (1.0 + x))), x); }

// The share of a disc of radius 1 where x > -d.
float DiscAbove(float d) {
  float x = clamp(d, -1.0, 1.0);
  return 0.5 + (x * sqrt((1.0 - x) * (1.0 + x)) + ArcSine(x)) / kPi;
}

float HalfChords(float radius, float y) {
  float ratio = clamp(y / radius, -1.0, 1.0);
  return radius * radius * (ratio * sqrt((1.0 - ratio) * (1.0 + ratio)) + ArcSine(ratio));
}

// A disc of directions, as projected on a surface that faces it. A small one, of which the difference below would
// be lost, is flat.
float SkyDiscAbove(float sin_radius, float sin_height) {
  float h = abs(sin_height);
  if (h >= sin_radius) return sin_height > 0.0 ? 1.0 : 0.0;
  if (sin_radius < 0.05) return DiscAbove(sin_height / sin_radius);
  float y = sqrt((sin_radius * sin_radius - h * h) / (1.0 - h * h));
  float beyond = (HalfChords(sin_radius, y) - h * HalfChords(1.0, y)) / (kPi * sin_radius * sin_radius);
  return sin_height > 0.0 ? 1.0 - beyond : beyond;
}

float SphereAbove(vec3 to_center, float radius, vec3 n) {
  float distance2 = dot(to_center, to_center), radius2 = radius * radius, height = dot(n, to_center);
  if (distance2 <= radius2) return 1.0;
  if (abs(height) >= radius) return height > 0.0 ? 1.0 : 0.0;
  return DiscAbove(height * sqrt((distance2 - radius2) / (distance2 - height * height)) / radius);
}

float DiskAbove(Light light, vec3 to_center, vec3 n) {
  float height = dot(n, to_center), reach = light.b.w * length(cross(light.b.xyz, n));
  if (abs(height) >= reach) return height > 0.0 ? 1.0 : 0.0;
  return DiscAbove(height / reach);
}

float LightAbovePlane(Light light, vec3 point, vec3 n) {
  vec3 to_light = light.a.xyz - point;
  switch (int(light.emission.w)) {
    case kRectangle:
      if (!SeesEmittingSide(point, to_light, cross(light.b.xyz, light.c.xyz), light.a.w)) return 0.0;
      return SquareAbove(dot(n, to_light), dot(n, light.b.xyz), dot(n, light.c.xyz));
    case kDisk:
      if (!SeesEmittingSide(point, to_light, light.b.xyz, light.a.w)) return 0.0;
      return DiskAbove(light, to_light, n);
    case kSphere:
      return SphereAbove(to_light, light.b.w, n);
    case kPoint:
    case kSpot:
      return dot(n, to_light) > 0.0 ? 1.0 : 0.0;
    default:
      return SkyDiscAbove(light.b.w, dot(n, light.a.xyz));
  }
}
)glsl";

}  // namespace

std::string LightAbovePlaneGlsl() { return kGlsl; }

}  // namespace penumbra
