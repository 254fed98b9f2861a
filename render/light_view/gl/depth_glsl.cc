#include "render/light_view/gl/depth_glsl.h"

#include "absl/strings/str_cat.h"
#include "render/light_view/depth_source.h"
#include "render/light_view/gl/mesh_store.h"
#include "render/light_view/gl/triangle_glsl.h"

namespace penumbra {
namespace {

// Further out than this, triangles are not drawn as such: their candidates are all pixels.
constexpr double kFarPixels = 65536;

constexpr char kInputs[] = R"glsl(
layout(std430, binding = kPositionsBinding) readonly buffer Positions { float positions[]; };
layout(std430, binding = kIndicesBinding) readonly buffer Indices { uint indices[]; };
layout(std140, binding = kDepthViewBinding) uniform View {
  dvec4 origin, row_x, row_y, row_w, row_near, limits;
};

uniform vec3 column0, column1, column2, column3;
uniform ivec2 size, rows;

// Linear in (column, row, 1).
flat out dvec3 edge[3];  // ≥ 0 inside
flat out dvec3 plane;
flat out vec2 range;  // of the corners, in which the plane is kept

)glsl";

constexpr char kVertex[] = R"glsl(
const vec4 kNowhere = vec4(2.0, 2.0, 2.0, 1.0);

struct Corner {
  vec3 world;
  dvec3 place;  // (x w, y w, w)
  double near;
};

Corner CornerOf(uint vertex) {
  vec3 p = vec3(positions[3u * vertex], positions[3u * vertex + 1u], positions[3u * vertex + 2u]);
  precise vec3 world = column0 * p.x + column1 * p.y + column2 * p.z + column3;
  dvec3 offset = dvec3(world) - origin.xyz;
  Corner corner;
  corner.world = world;
  corner.place = dvec3(dot(row_x.xyz, offset) + row_x.w, dot(row_y.xyz, offset) + row_y.w,
                       dot(row_w.xyz, offset) + row_w.w);
  corner.near = dot(row_near.xyz, offset) + row_near.w;
  return corner;
}

bool IsBefore(vec3 a, vec3 b) {
  if (a.x != b.x) return a.x < b.x;
  if (a.y != b.y) return a.y < b.y;
  return a.z < b.z;
}

// Whichever triangle asks, an edge is computed from the same end, so that the two that share it get
// the same numbers with opposite signs.
dvec3 EdgeBetween(Corner a, Corner b) {
  bool turned = IsBefore(b.world, a.world);
  precise dvec3 line = cross(turned ? b.place : a.place, turned ? a.place : b.place);
  return turned ? -line : line;
}

bool AllBeyond(dvec3 distances) { return all(lessThan(distances, dvec3(0.0))); }

// Whether no pixel of the rows can see the triangle. Each test is linear, so that it holds for the
// triangle if it holds for the corners.
bool IsUnseen(dvec3 x, dvec3 y, dvec3 w) {
  double below = double(rows.x) - 1.0, above = double(rows.x + rows.y);
  return AllBeyond(w - limits.x) || AllBeyond(x + w) || AllBeyond(double(size.x) * w - x) ||
         AllBeyond(y - below * w) || AllBeyond(above * w - y);
}

vec4 PositionOf(int k, dvec3 a, dvec3 b, dvec3 c) {
  double least = min(min(a.z, b.z), c.z);
  if (least > 0.0 && least >= limits.x) {
    dvec2 p = a.xy / a.z, q = b.xy / b.z, r = c.xy / c.z;
    if (!SpansCenters(p, q, r)) return kNowhere;
    dvec2 reach = max(max(abs(p), abs(q)), abs(r));
    if (max(reach.x, reach.y) < kFarPixels) {
      dvec2 pixel = LargerCorner(k, p, q, r) + 0.5 - dvec2(0.0, rows.x);
      return vec4(vec2(2.0 * pixel / dvec2(size.x, rows.y) - 1.0), 0.0, 1.0);
    }
  }
  return vec4(k == 1 ? 3.0 : -1.0, k == 2 ? 3.0 : -1.0, 0.0, 1.0);
}

// The corner's own, that of the near plane where it is nearer.
double NearAt(Corner corner) {
  if (limits.x == 0.0) return corner.near;
  return 1.0 / max(corner.place.z, limits.x);
}

void main() {
  uint first = 3u * (uint(gl_VertexID) / 3u);
  Corner a = CornerOf(indices[first]);
  Corner b = CornerOf(indices[first + 1u]);
  Corner c = CornerOf(indices[first + 2u]);
  double volume = dot(a.place, cross(b.place, c.place));
  double side = volume < 0.0 ? -1.0 : 1.0;
  edge[0] = side * EdgeBetween(b, c);
  edge[1] = side * EdgeBetween(c, a);
  edge[2] = side * EdgeBetween(a, b);
  double unit = volume == 0.0 ? 0.0 : 1.0 / abs(volume);
  plane = unit * (a.near * edge[0] + b.near * edge[1] + c.near * edge[2]);
  dvec3 nears = dvec3(NearAt(a), NearAt(b), NearAt(c));
  range = vec2(min(min(nears.x, nears.y), nears.z), max(max(nears.x, nears.y), nears.z));
  bool is_unseen = volume == 0.0 || IsUnseen(dvec3(a.place.x, b.place.x, c.place.x),
                                             dvec3(a.place.y, b.place.y, c.place.y),
                                             dvec3(a.place.z, b.place.z, c.place.z));
  gl_Position = is_unseen ? kNowhere : PositionOf(gl_VertexID % 3, a.place, b.place, c.place);
  KeepUv(first, unit);
}
)glsl";

constexpr char kNoUv[] = "void KeepUv(uint first, double unit) {}\n";

constexpr char kKeepUv[] = R"glsl(
layout(std430, binding = kUvsBinding) readonly buffer Uvs { float uvs[]; };
flat out dvec3 plane_u, plane_v;

void KeepUv(uint first, double unit) {
  plane_u = plane_v = dvec3(0.0);
  for (uint k = 0u; k < 3u; ++k) {
    uint vertex = indices[first + k];
    plane_u += unit * double(uvs[2u * vertex]) * edge[k];
    plane_v += unit * double(uvs[2u * vertex + 1u]) * edge[k];
  }
}
)glsl";

constexpr char kFragmentInputs[] = R"glsl(
layout(std140, binding = kDepthViewBinding) uniform View {
  dvec4 origin, row_x, row_y, row_w, row_near, limits;
};

flat in dvec3 edge[3];
flat in dvec3 plane;
flat in vec2 range;

uniform ivec2 size, rows;

layout(location = 0) out float nearest;

)glsl";

constexpr char kNoMask[] = "bool IsHole(dvec3 pixel, double w) { return false; }\n";

constexpr char kMask[] = R"glsl(
flat in dvec3 plane_u, plane_v;

bool IsHole(dvec3 pixel, double w) {
  return IsHoleAt(vec2(dvec2(dot(plane_u, pixel), dot(plane_v, pixel)) * w));
}
)glsl";

constexpr char kFragment[] = R"glsl(
void main() {
  dvec3 pixel = dvec3(floor(gl_FragCoord.xy) + vec2(0.0, rows.x), 1.0);
  for (int k = 0; k < 3; ++k) {
    precise double inside = edge[k].x * pixel.x + edge[k].y * pixel.y + edge[k].z;
    if (inside < 0.0) discard;
  }
  double near = dot(plane, pixel);
  // From a point 1/near is the depth.
  bool has_near = limits.x > 0.0;
  if (has_near && !(near > 0.0 && near * limits.x <= 1.0)) discard;
  if (IsHole(pixel, has_near ? 1.0 / near : 1.0)) discard;
  nearest = clamp(float(near), range.x, range.y);
}
)glsl";

}  // namespace

GpuDepthView::GpuDepthView(const LightView& view) {
  const Basis& axes = view.frame.axes;
  const DVec2 scale = view.pixels_per_slope();
  const DVec2 first = view.window.min * scale + 0.5;  // the centre of pixel (0, 0)
  const DVec3& eye = view.eye;
  origin = DVec4(view.frame.origin, 0);
  if (view.from_infinity) {
    row_x = DVec4(scale.x * (axes.s + eye.x * axes.n), -first.x);
    row_y = DVec4(scale.y * (axes.t + eye.y * axes.n), -first.y);
    row_w = DVec4(0, 0, 0, 1);
    row_near = DVec4(-axes.n, 0);
    return;
  }
  row_x = DVec4(scale.x * axes.s - first.x * axes.n, first.x * eye.z - scale.x * eye.x);
  row_y = DVec4(scale.y * axes.t - first.y * axes.n, first.y * eye.z - scale.y * eye.y);
  row_w = DVec4(axes.n, -eye.z);
  row_near = DVec4(0, 0, 0, 1);
  limits.x = view.near * (1 - kNearMargin);
}

gl::ProgramSource DepthProgram(bool masked) {
  return {.vertex = absl::StrCat(TriangleCoverGlsl(), kInputs, masked ? kKeepUv : kNoUv, kVertex),
          .fragment = masked ? absl::StrCat(kFragmentInputs, AlphaMaskGlsl(), kMask, kFragment)
                             : absl::StrCat(kFragmentInputs, kNoMask, kFragment),
          .constants = absl::StrCat(gl::GlslConstant("kFarPixels", kFarPixels),
                                    gl::GlslConstant("kPositionsBinding", kPositionsBinding),
                                    gl::GlslConstant("kIndicesBinding", kIndicesBinding),
                                    gl::GlslConstant("kUvsBinding", kUvsBinding),
                                    gl::GlslConstant("kDepthViewBinding", kDepthViewBinding))};
}

}  // namespace penumbra
