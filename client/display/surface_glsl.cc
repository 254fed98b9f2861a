#include "client/display/surface_glsl.h"

#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/substitute.h"
#include "client/display/form_factor_glsl.h"
#include "client/display/light_above_plane_glsl.h"
#include "client/display/visibility_glsl.h"

namespace penumbra {
namespace {

// Positions are interpolated inside the face even where a pixel's centre lies outside: at the
// border of a receiver the point must not fall off its edge.
constexpr char kVertexGlsl[] = R"glsl(
layout(location = 0) in vec3 position_mesh;
layout(location = 1) in vec3 normal_mesh;
layout(location = 2) in vec2 uv_mesh;
uniform mat4 clip_from_mesh;
uniform mat4 world_from_mesh;
uniform mat4 world_from_mesh_normal;
uniform float depth_scale;  // above 1 brings the surface nearer in depth, not in place
out vec3 position_at_center;
centroid out vec3 position_inside;
centroid out vec3 vertex_normal;
centroid out vec2 uv;

void main() {
  position_at_center = (world_from_mesh * vec4(position_mesh, 1.0)).xyz;
  position_inside = position_at_center;
  vertex_normal = mat3(world_from_mesh_normal) * normal_mesh;
  uv = uv_mesh;
  gl_Position = clip_from_mesh * vec4(position_mesh, 1.0);
  gl_Position.z *= depth_scale;
}
)glsl";

// What both fragment shaders know of the face they are on.
constexpr char kFaceGlsl[] = R"glsl(
layout(std430, binding = $0) readonly buffer FaceNormals { float face_normals[]; };
uniform mat4 world_from_mesh_normal;
uniform bool has_face_normals;
uniform vec3 eye;
in vec3 position_at_center;
centroid in vec3 position_inside;
centroid in vec3 vertex_normal;
centroid in vec2 uv;
layout(location = 0) out vec4 pixel;

// Where the face is lit: at the pixel's centre, so that the faces which share a pixel agree; but not where
// the face, seen almost edge on, runs far off before it gets there.
vec3 Position() {
  const float far_off = 0.01;  // of the distance from the eye; some ten pixels
  bool is_near = distance(position_at_center, position_inside) <= far_off * distance(eye, position_inside);
  return is_near ? position_at_center : position_inside;
}

// Of the side that the triangle's winding makes its front.
vec3 FaceNormal() {
  if (!has_face_normals) return normalize(cross(dFdx(position_at_center), dFdy(position_at_center)));
  int first = 3 * gl_PrimitiveID;
  vec3 n = vec3(face_normals[first], face_normals[first + 1], face_normals[first + 2]);
  return normalize(mat3(world_from_mesh_normal) * n);
}
)glsl";

constexpr char kSurfaceGlsl[] = R"glsl(
layout(std430, binding = $0) readonly buffer Lights { Light lights[]; };
layout(std430, binding = $1) readonly buffer Receivers { Receiver receivers[]; };
layout(std430, binding = $2) readonly buffer Candidates { uvec2 candidates[]; };  // light, receiver
layout(binding = $3) uniform sampler2D mask;
uniform bool has_mask;
uniform float alpha_cutoff;
uniform vec3 color;
uniform vec3 ambient;
uniform float clip_radiance;
uniform bool culls_back_faces;
uniform bool has_vertex_normals;
uniform bool receives;
// Of the order that DrawnLight() has. Mesa's software device runs all of a loop's body for lights that it
// skips, so that none are.
uniform int first_light;
uniform int end_light;
uniform bool adds_ambient;
uniform uint first_candidate;
uniform uint end_candidate;

// The opacity of the texel that holds uv: nearest, repeating.
float Opacity() {
  ivec2 size = textureSize(mask, 0);
  ivec2 texel = ivec2((uv - floor(uv)) * vec2(size));
  return texelFetch(mask, min(texel, size - 1), 0).r;
}

vec3 pixel_x = vec3(0.0), pixel_y = vec3(0.0);  // to the same face's place in the next pixel

// How well the receiver fits this point: 4 when the surface is the receiver, 3 where a texel of it lies here, 2 or
// 1 next to one, 0 where the point is not on it.
int Fit(uint code, vec3 face_normal) {
  Receiver receiver = receivers[code & ~$6u];
  if ((code & $4u) != 0u) return 4;
  vec2 at = UvOnReceiver(receiver, Position());
  // Of the receiver's edge, for rounding; where the face has but a part of the pixel, as far as the pixel reaches.
  vec2 rim = vec2(1e-4);
  if (position_at_center != position_inside) {
    rim += abs(AcrossReceiver(receiver, pixel_x)) + abs(AcrossReceiver(receiver, pixel_y));
  }
  // At the centre, where a point is still on its plane: Mesa's software device divides what it interpolates
  // elsewhere by the centre's w.
  float height = dot(receiver.normal.xyz, position_at_center - receiver.origin.xyz);
  bool is_on = abs(height) <= receiver.origin.w && abs(dot(face_normal, receiver.normal.xyz)) > 0.999 &&
               all(greaterThanEqual(at, -rim)) && all(lessThanEqual(at, 1.0 + rim));
  if (!is_on) return 0;
  int coverage = Coverage(receiver, at);
  return coverage == 1 && (code & $5u) == 0u ? 0 : coverage;
}

// What a point on the receiver gets of the light.
float ShareOn(uint code, vec3 position, vec3 n) {
  Receiver receiver = receivers[code & ~$6u];
  bool from_behind = dot(n, receiver.normal.xyz) < 0.0;
  if (from_behind && receiver.normal.w == 0.0) return 0.0;
  return SmoothVisibility(receiver, UvOnReceiver(receiver, position));
}

// What part of the most that can be seen is seen.
float ShareAbove(float seen, float most) { return most > 0.0 ? min(1.0, seen / most) : 0.0; }

vec3 Shade(vec3 position, vec3 face_normal, vec3 n) {
  vec3 sum = adds_ambient ? ambient : vec3(0.0);
  uint next = first_candidate;
  for (int k = first_light; k < end_light; ++k) {
    int i = DrawnLight(k);
    int best = 0;
    uint chosen = 0u;
    for (; next < end_candidate && candidates[next].x == uint(i); ++next) {
      if (best >= 3) continue;
      int fit = Fit(candidates[next].y, face_normal);
      if (fit > best) {
        best = fit;
        chosen = candidates[next].y;
      }
    }
    float share = 1.0, value;
    if (FindInPicture(i, position_at_center, position_inside, value)) {
      share = HasShares(i) ? ShareAbove(value, LightAbovePlane(lights[i], position, face_normal))
                           : ShareAbove(value, UnoccludedFactor(lights[i], position, face_normal));
    } else if (best > 0) {
      share = ShareOn(chosen, position, n);
    } else if (receives && HasLayers(i)) {
      share = ShareAbove(LayerVisibility(i, position, face_normal),
                         LightAbovePlane(lights[i], position, face_normal));
    } else if (receives && HasWidths(i)) {
      share = ShareAbove(WidthVisibility(i, position, face_normal),
                         LightAbovePlane(lights[i], position, face_normal));
    }
    if (share > 0.0) sum += share * UnoccludedRadiance(lights[i], position, n);
  }
  return color * sum;
}

void main() {
  pixel_x = dFdx(position_at_center);
  pixel_y = dFdy(position_at_center);
  if (has_mask && Opacity() < alpha_cutoff) discard;
  vec3 face_normal = FaceNormal();
  bool from_behind = dot(face_normal, eye - position_inside) < 0.0;
  if (from_behind && culls_back_faces) discard;
  if (from_behind) face_normal = -face_normal;
  vec3 n = face_normal;
  if (has_vertex_normals && dot(vertex_normal, vertex_normal) > 0.0) {
    n = normalize(vertex_normal);
    if (dot(n, face_normal) < 0.0) n = -n;
  }
  pixel = vec4(min(Shade(Position(), face_normal, n), vec3(clip_radiance)), 1.0);
}
)glsl";

constexpr char kGlowGlsl[] = R"glsl(
uniform vec3 radiance;
uniform float clip_radiance;
uniform bool two_sided;

void main() {
  // From behind a light that shines one way one looks past it.
  if (!two_sided && dot(FaceNormal(), eye - position_inside) < 0.0) discard;
  pixel = vec4(min(radiance, vec3(clip_radiance)), 1.0);
}
)glsl";

std::string FaceGlsl() { return absl::Substitute(kFaceGlsl, kFaceNormalsBinding); }

}  // namespace

gl::ProgramSource SurfaceProgram() { return SurfaceProgram(ShadowWordsGlsl(kShadowWordBindings)); }

gl::ProgramSource SurfaceProgram(const std::string& shadow_words_glsl) {
  return {.vertex = kVertexGlsl,
          .fragment = absl::StrCat(FormFactorGlsl(), LightAbovePlaneGlsl(), shadow_words_glsl,
                                   VisibilityGlsl(kCountsBinding), FaceGlsl(),
                                   absl::Substitute(kSurfaceGlsl, kLightsBinding, kReceiversBinding,
                                                    kCandidatesBinding, kMaskUnit, kIsTheReceiver,
                                                    kIsPartOfIt, kIsTheReceiver | kIsPartOfIt))};
}

gl::ProgramSource GlowProgram() {
  return {.vertex = kVertexGlsl, .fragment = absl::StrCat(FaceGlsl(), kGlowGlsl)};
}

}  // namespace penumbra
