#include "client/display/shadow_width_glsl.h"

namespace penumbra {
namespace {

// As in render/artifact/shadow_width_map.cc and light_width.cc, where it is derived.
constexpr char kGlsl[] = R"glsl(
float WordAt(uint first, uint i) { return uintBitsToFloat(words[first + i]); }

float DepthAt(bool from_infinity, float nearness) { return from_infinity ? -nearness : 1.0 / nearness; }

float Attenuation(float shadow_depth, float shadow_width, float c_scale, float c_bias) {
  if (!(shadow_depth > 0.0) || !(shadow_width > 0.0)) return 1.0;
  if (isinf(shadow_width)) return 0.0;
  return clamp(1.0 + c_bias - c_scale * shadow_width / shadow_depth, 0.0, 1.0);
}

// The light's width at `at` on the image, along `direction`, or its mean.
float LightWidthAlong(LightFace face, vec2 at, vec2 direction) {
  bool has_direction = direction != vec2(0.0);
  float square = 0.0;
  for (uint k = 0u; k < 3u; ++k) {
    vec3 axis = vec3(WordAt(face.rest.z, 3u * k), WordAt(face.rest.z, 3u * k + 1u), WordAt(face.rest.z, 3u * k + 2u));
    vec2 shift = face.origin.w != 0.0 ? axis.xy : at * axis.z - axis.xy;
    float along = dot(shift, direction);
    square += has_direction ? along * along : 0.5 * dot(shift, shift);
  }
  return sqrt(square);
}

// Texel i of a layer: width, 0 where it is not in shadow, and the blocker's nearness.
vec2 WidthInLayer(uint first_depth, uint first_width, bool from_infinity, uint i, float nearness) {
  float width = WordAt(first_width, i);
  float blocker = NearnessOf(from_infinity, WordAt(first_depth, i));
  return width > 0.0 && nearness < blocker ? vec2(width, blocker) : vec2(0.0);
}

vec2 GrowthDirection(vec2 texels[4], vec2 t) {
  vec4 w = min(vec4(texels[0].x, texels[1].x, texels[2].x, texels[3].x), vec4(1e30));
  vec2 growth = vec2(mix(w.y - w.x, w.w - w.z, t.y), mix(w.z - w.x, w.w - w.y, t.x));
  float most = max(abs(growth.x), abs(growth.y));  // squares of what is large have no floats
  return most > 0.0 ? normalize(growth / most) : vec2(0.0);
}

// What one layer's texels leave of the light.
float ShareBehind(int light, LightFace face, PlaneOnImage plane, vec2 texels[4], vec4 weights, vec2 t) {
  float shadowed = 0.0, width = 0.0, nearness = 0.0;
  for (int k = 0; k < 4; ++k) {
    if (!(texels[k].x > 0.0) || !(weights[k] > 0.0)) continue;
    shadowed += weights[k];
    width += weights[k] * texels[k].x;
    nearness += weights[k] * texels[k].y;
  }
  if (!(shadowed > 0.0)) return 1.0;
  width /= dot(weights, vec4(1.0));
  bool from_infinity = face.origin.w != 0.0;
  float blocker = DepthAt(from_infinity, nearness / shadowed);
  float depth = DepthAt(from_infinity, plane.nearness);
  float per_window = from_infinity ? 1.0 : depth;
  float shadow_depth = depth - blocker;
  float c_scale = shadow_depth * face.window.z / per_window;
  float asked = uintBitsToFloat(light_shadows[light].widths.z);
  if (asked >= 0.0) {
    c_scale = min(c_scale, asked);
  } else {
    vec2 at = face.window.xy + plane.at / face.window.zw;
    float light_width = LightWidthAlong(face, at, GrowthDirection(texels, t));
    if (light_width > 0.0) c_scale = min(c_scale, (from_infinity ? 1.0 : blocker) / light_width);
  }
  return Attenuation(shadow_depth, per_window * width, c_scale, uintBitsToFloat(light_shadows[light].widths.w));
}

float VisibilityByWidth(int light, LightFace face, PlaneOnImage plane) {
  bool from_infinity = face.origin.w != 0.0;
  bool has_far = face.rest.y != 0u;
  vec2 first = floor(plane.at - 0.5), t = plane.at - 0.5 - first;
  float spread = plane.width + abs(plane.gradient.x) + abs(plane.gradient.y);
  vec4 weights = vec4(0.0);
  vec2 near[4] = vec2[4](vec2(0.0), vec2(0.0), vec2(0.0), vec2(0.0)), far[4] = near;
  vec3 sums = vec3(0.0);  // nearness of both layers where there are two, and how many there are
  for (int k = 0; k < 4; ++k) {
    ivec2 place = ivec2(first) + ivec2(k & 1, k >> 1);
    if (any(lessThan(place, ivec2(0))) || any(greaterThanEqual(place, ivec2(face.image.xy)))) continue;
    vec2 away = vec2(place) + 0.5 - plane.at;
    weights[k] = (1.0 - abs(away.x)) * (1.0 - abs(away.y));
    uint i = uint(place.y) * face.image.x + uint(place.x);
    float nearness = plane.nearness + dot(plane.gradient, away) + spread;
    near[k] = WidthInLayer(face.image.z, face.image.w, from_infinity, i, nearness);
    if (!has_far) continue;
    far[k] = WidthInLayer(face.rest.x, face.rest.y, from_infinity, i, nearness);
    if (far[k].x > 0.0) sums += vec3(near[k].y, far[k].y, 1.0);
  }
  for (int k = 0; sums.z > 0.0 && k < 4; ++k) {
    bool has_one = near[k].x > 0.0 && !(far[k].x > 0.0);
    if (has_one && 2.0 * sums.z * near[k].y < sums.x + sums.y) {
      far[k] = near[k];
      near[k] = vec2(0.0);
    }
  }
  float share = ShareBehind(light, face, plane, near, weights, t);
  return has_far ? min(share, ShareBehind(light, face, plane, far, weights, t)) : share;
}

bool TellsOf(LightFace face, vec2 at) {
  vec2 begin = vec2(WordAt(face.rest.z, 9u), WordAt(face.rest.z, 10u)) - 1.0;
  vec2 end = vec2(WordAt(face.rest.z, 11u), WordAt(face.rest.z, 12u)) + 1.0;
  return all(greaterThanEqual(at, begin)) && all(lessThanEqual(at, end));
}

bool HasWidths(int light) { return light_shadows[light].widths.y > 0u; }

float WidthVisibility(int light, vec3 point, vec3 n) {
  uvec4 widths = light_shadows[light].widths;
  for (uint i = widths.x; i < widths.x + widths.y; ++i) {
    PlaneOnImage plane;
    if (FindOnImage(light_faces[i], point, n, plane) && TellsOf(light_faces[i], plane.at)) {
      return VisibilityByWidth(light, light_faces[i], plane);
    }
  }
  return 1.0;
}
)glsl";

}  // namespace

std::string ShadowWidthGlsl() { return kGlsl; }

}  // namespace penumbra
