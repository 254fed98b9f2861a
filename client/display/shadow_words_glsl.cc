#include "client/display/shadow_words_glsl.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/substitute.h"
#include "client/display/shadow_width_glsl.h"
#include "render/artifact/plane_on_image.h"
#include "render/gl/program.h"

namespace penumbra {
namespace {

constexpr char kBlocks[] = R"glsl(
struct LightShadow {
  uvec4 layers;  // first face, faces, samples, tolerance
  uvec4 widths;  // first face, faces, c_scale, c_bias
  mat4 pixel_from_world;
  uvec4 picture;  // width, height, first word, whether it has shares
  uvec4 drawn_light;
};
struct LightFace {
  vec4 origin;
  vec4 s;
  vec4 t;
  vec4 n;
  vec4 window;
  uvec4 image;  // width, height; GpuLightFace::first_words, two of them
  uvec4 rest;   // the other four
};
layout(std430, binding = $0) readonly buffer LightShadows { LightShadow light_shadows[]; };
layout(std430, binding = $1) readonly buffer LightFaces { LightFace light_faces[]; };
layout(std430, binding = $2) readonly buffer Words { uint words[]; };
)glsl";

// As in render/artifact/plane_on_image.cc and attenuation_ldi.cc, where it is derived.
constexpr char kGlsl[] = R"glsl(
const int kSeen = 0, kHidden = 1, kAbsent = 2;

float NearnessOf(bool from_infinity, float depth) { return from_infinity ? -depth : 1.0 / depth; }

int FindLayer(LightFace face, uint pixel, float nearness, float tolerance, out uint count) {
  bool from_infinity = face.origin.w != 0.0;
  int sight = kAbsent;
  float least = tolerance;
  count = 0u;
  uint end = words[face.image.z + pixel + 1u];
  for (uint i = words[face.image.z + pixel]; i < end; ++i) {
    float nearer = NearnessOf(from_infinity, uintBitsToFloat(words[face.image.w + i])) - nearness;
    if (abs(nearer) <= least) {
      least = abs(nearer);
      sight = kSeen;
      count = (words[face.rest.x + (i >> 1)] >> (16u * (i & 1u))) & 0xffffu;
    } else if (nearer > tolerance && sight == kAbsent) {
      sight = kHidden;
    }
  }
  return sight;
}

float CutSlope(float slope, float limit) { return isnan(slope) ? limit : clamp(slope, -limit, limit); }

// The plane through a point, on a face's image.
struct PlaneOnImage {
  vec2 at;
  float nearness;
  vec2 gradient;
  float width;
};

bool FindOnImage(LightFace face, vec3 point, vec3 n, out PlaneOnImage plane) {
  bool from_infinity = face.origin.w != 0.0;
  vec3 way = point - face.origin.xyz;
  vec3 q = vec3(dot(way, face.s.xyz), dot(way, face.t.xyz), dot(way, face.n.xyz));
  if (!from_infinity && !(q.z > 0.0)) return false;
  vec2 slope = from_infinity ? q.xy : q.xy / q.z;
  plane.at = (slope - face.window.xy) * face.window.zw;
  if (!(all(greaterThanEqual(plane.at, vec2(0.0))) && all(lessThanEqual(plane.at, vec2(face.image.xy))))) {
    return false;
  }
  vec3 normal = vec3(dot(n, face.s.xyz), dot(n, face.t.xyz), dot(n, face.n.xyz));
  vec2 pixel = 1.0 / face.window.zw;
  plane.nearness = NearnessOf(from_infinity, q.z);
  plane.width = max(pixel.x, pixel.y) * (from_infinity ? 1.0 : plane.nearness);
  float facing = from_infinity ? normal.z : dot(normal, q);
  float limit = kMaxSteepness * plane.width;
  plane.gradient = vec2(CutSlope(pixel.x * normal.x / facing, limit), CutSlope(pixel.y * normal.y / facing, limit));
  return true;
}

float VisibilityOnFace(LightFace face, uint samples, float pixels, PlaneOnImage plane) {
  float tolerance = pixels * (plane.width + abs(plane.gradient.x) + abs(plane.gradient.y));
  vec2 first = floor(plane.at - 0.5);
  float seen = 0.0, weights = 0.0;
  for (int k = 0; k < 4; ++k) {
    ivec2 place = ivec2(first) + ivec2(k & 1, k >> 1);
    if (any(lessThan(place, ivec2(0))) || any(greaterThanEqual(place, ivec2(face.image.xy)))) continue;
    vec2 away = vec2(place) + 0.5 - plane.at;
    uint count;
    int sight = FindLayer(face, uint(place.y) * face.image.x + uint(place.x),
                          plane.nearness + dot(plane.gradient, away), tolerance, count);
    if (sight == kAbsent) continue;
    float weight = (1.0 - abs(away.x)) * (1.0 - abs(away.y));
    weights += weight;
    seen += weight * float(count);
  }
  return weights > 0.0 ? seen / (weights * float(samples)) : 1.0;
}

int DrawnLight(int place) { return int(light_shadows[place].drawn_light.x); }

bool HasLayers(int light) { return light_shadows[light].layers.y > 0u; }

float LayerVisibility(int light, vec3 point, vec3 n) {
  uvec4 layers = light_shadows[light].layers;
  for (uint i = layers.x; i < layers.x + layers.y; ++i) {
    PlaneOnImage plane;
    if (FindOnImage(light_faces[i], point, n, plane)) {
      return VisibilityOnFace(light_faces[i], layers.z, uintBitsToFloat(layers.w), plane);
    }
  }
  return 1.0;
}

// The pixel of a picture whose centre the face fills; where it fills none here, that on the side where it has some of
// this one.
bool FindInPicture(int light, vec3 at_center, vec3 inside, out float value) {
  uvec4 image = light_shadows[light].picture;
  if (image.x == 0u) return false;
  vec4 center = light_shadows[light].pixel_from_world * vec4(at_center, 1.0);
  vec4 some = light_shadows[light].pixel_from_world * vec4(inside, 1.0);
  if (!(center.w > 0.0 && some.w > 0.0)) return false;
  ivec2 place = ivec2(floor(center.xy / center.w));
  vec2 side = some.xy / some.w - center.xy / center.w;
  float most = max(abs(side.x), abs(side.y));
  if (most > 1e-3) place += ivec2(round(side / most));
  if (any(lessThan(place, ivec2(0))) || any(greaterThanEqual(place, ivec2(image.xy)))) return false;
  value = uintBitsToFloat(words[image.z + uint(place.y) * image.x + uint(place.x)]);
  return value >= 0.0;
}

bool HasShares(int light) { return light_shadows[light].picture.w != 0u; }
)glsl";

}  // namespace

std::string ShadowWordBlocksGlsl(const ShadowWordBindings& bindings) {
  return absl::Substitute(kBlocks, bindings.shadows, bindings.faces, bindings.words);
}

std::string ShadowWordsGlsl(const ShadowWordBindings& bindings) {
  return absl::StrCat(gl::GlslConstant("kMaxSteepness", kMaxSteepness),
                      ShadowWordBlocksGlsl(bindings), kGlsl, ShadowWidthGlsl());
}

}  // namespace penumbra
