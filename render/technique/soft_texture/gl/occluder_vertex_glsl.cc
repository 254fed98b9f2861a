#include "render/technique/soft_texture/gl/occluder_vertex_glsl.h"

#include "absl/strings/str_cat.h"
#include "render/light_view/gl/triangle_glsl.h"

namespace penumbra::texture_gl {
namespace {

constexpr char kEdge[] = R"glsl(
// Linear in (column, row): x, y and z times (column − from.x, row − from.y, 1) is ≥ 0 on the inside
// of triangles of one orientation and ≤ 0 on that of the other.
struct Edge {
  vec3 line;
  vec2 from;
  double scale;  // times this it is the barycentric coordinate, but for a factor all three share
};
)glsl";

constexpr char kInputs[] = R"glsl(
layout(std430, binding = kPositionsBinding) readonly buffer Positions { float positions[]; };
layout(std430, binding = kIndicesBinding) readonly buffer Indices { uint indices[]; };

struct SampleMap { dvec4 row_x, row_y, row_w, light; };
layout(std140, binding = kMapsBinding) uniform Maps {
  dvec4 front;
  SampleMap maps[kSamplesPerPass];
};

uniform vec3 column0, column1, column2, column3, origin;
uniform vec2 heights;
uniform int facing, first_sample;
uniform ivec2 size, rows;

flat out vec3 edge[3];
flat out vec2 from[3];
flat out vec3 scale, corner_w, corner_height;
flat out ivec2 is_cut;  // by the light's plane, by the receiver's
flat out float surface_offset;
flat out uvec2 bit;

)glsl";

constexpr char kVertex[] = R"glsl(
struct Corner {
  vec3 world;
  dvec3 place;  // (X w, Y w, w)
  double height;
};

Corner CornerOf(uint vertex, SampleMap map) {
  vec3 p = vec3(positions[3u * vertex], positions[3u * vertex + 1u], positions[3u * vertex + 2u]);
  precise vec3 world = column0 * p.x + column1 * p.y + column2 * p.z + column3;
  dvec3 offset = dvec3(world) - dvec3(origin);
  Corner corner;
  corner.world = world;
  corner.place = dvec3(dot(map.row_x.xyz, offset) + map.row_x.w,
                       dot(map.row_y.xyz, offset) + map.row_y.w,
                       dot(map.row_w.xyz, offset) + map.row_w.w);
  corner.height = map.light.x * dot(front.xyz, offset);
  return corner;
}

bool IsBefore(vec3 a, vec3 b) {
  if (a.x != b.x) return a.x < b.x;
  if (a.y != b.y) return a.y < b.y;
  return a.z < b.z;
}

// Whichever triangle asks, an edge is computed from the same end, so that the two that share it get
// the same numbers with opposite signs.
Edge EdgeBetween(Corner a, Corner b) {
  bool turned = IsBefore(b.world, a.world);
  dvec3 p = turned ? b.place : a.place;
  dvec3 q = turned ? a.place : b.place;
  precise dvec3 n = cross(p, q);
  dvec2 start = p.z > 0.0 ? p.xy / p.z : q.z > 0.0 ? q.xy / q.z : dvec2(0.0);
  Edge e;
  e.from = vec2(round(clamp(start, dvec2(0.0), dvec2(size))));
  double largest = max(abs(n.x), abs(n.y));
  double unit = largest > 0.0 ? 1.0 / largest : 1.0;
  precise double constant = dot(n, dvec3(e.from, 1.0)) * unit;
  e.line = vec3(n.xy * unit, constant) * (turned ? -1.0 : 1.0);
  e.scale = 1.0 / unit;
  return e;
}

bool AllBeyond(dvec3 distances) { return all(lessThan(distances, dvec3(0.0))); }

// Whether no texel of the rows can be in the triangle's shadow. Each test is linear, so that it
// holds for the triangle if it holds for the corners.
bool CastsNothing(dvec3 x, dvec3 y, dvec3 w, dvec3 height) {
  double below = double(rows.x) - 1.0, above = double(rows.x + rows.y);
  return all(lessThanEqual(height, dvec3(front.w))) || AllBeyond(w - kSmallestW) ||
         AllBeyond(x + w) || AllBeyond(double(size.x) * w - x) || AllBeyond(y - below * w) ||
         AllBeyond(above * w - y);
}

const vec4 kNowhere = vec4(2.0, 2.0, 2.0, 1.0);

vec4 PositionOf(int k, dvec3 a, dvec3 b, dvec3 c, double facing_side) {
  if (min(min(a.z, b.z), c.z) >= kSmallestW) {
    dvec2 p = a.xy / a.z, q = b.xy / b.z, r = c.xy / c.z;
    if (!SpansCenters(p, q, r) || Cross(q - p, r - p) * facing_side < 0.0) return kNowhere;
    dvec2 reach = max(max(abs(p), abs(q)), abs(r));
    if (max(reach.x, reach.y) < kFarTexels) {
      dvec2 pixel = LargerCorner(k, p, q, r) + 0.5 - dvec2(0.0, rows.x);
      return vec4(vec2(2.0 * pixel / dvec2(size.x, rows.y) - 1.0), 0.0, 1.0);
    }
  }
  return vec4(k == 1 ? 3.0 : -1.0, k == 2 ? 3.0 : -1.0, 0.0, 1.0);
}

void main() {
  uint first = 3u * (uint(gl_VertexID) / 3u);
  int number = first_sample + gl_InstanceID;
  SampleMap map = maps[number];
  Corner a = CornerOf(indices[first], map);
  Corner b = CornerOf(indices[first + 1u], map);
  Corner c = CornerOf(indices[first + 2u], map);
  Edge edges[3] = Edge[3](EdgeBetween(b, c), EdgeBetween(c, a), EdgeBetween(a, b));
  double largest = max(edges[0].scale, max(edges[1].scale, edges[2].scale));
  for (int k = 0; k < 3; ++k) {
    edge[k] = edges[k].line;
    from[k] = edges[k].from;
    scale[k] = largest > 0.0 ? float(edges[k].scale / largest) : 0.0;
  }
  dvec3 w = dvec3(a.place.z, b.place.z, c.place.z);
  dvec3 height = dvec3(a.height, b.height, c.height);
  corner_w = vec3(w);
  corner_height = vec3(height);
  is_cut = ivec2(any(lessThan(w, dvec3(kSmallestW))), any(lessThanEqual(height, dvec3(front.w))));
  surface_offset = float(front.w);
  bit = number < 32 ? uvec2(1u << number, 0u) : uvec2(0u, 1u << (number - 32));
  // Faces that look away from the light are left out where those towards it cover the same: of a
  // mesh that neither the plane cuts nor the light is close to.
  double side = map.light.x;
  bool is_whole = (side > 0.0 ? heights.x : -heights.y) > front.w &&
                  (side > 0.0 ? heights.y : -heights.x) <= (1.0 - kNearLightW) * map.light.y;
  gl_Position = CastsNothing(dvec3(a.place.x, b.place.x, c.place.x),
                             dvec3(a.place.y, b.place.y, c.place.y), w, height)
                    ? kNowhere
                    : PositionOf(gl_VertexID % 3, a.place, b.place, c.place,
                                 is_whole ? side * double(facing) : 0.0);
  KeepUv(first);
}
)glsl";

constexpr char kNoUv[] = "void KeepUv(uint first) {}\n";

constexpr char kKeepUv[] = R"glsl(
layout(std430, binding = kUvsBinding) readonly buffer Uvs { float uvs[]; };
flat out vec2 corner_uv[3];

void KeepUv(uint first) {
  for (uint k = 0u; k < 3u; ++k) {
    uint vertex = indices[first + k];
    corner_uv[k] = vec2(uvs[2u * vertex], uvs[2u * vertex + 1u]);
  }
}
)glsl";

}  // namespace

std::string OccluderVertexGlsl(bool masked) {
  return absl::StrCat(kEdge, TriangleCoverGlsl(), kInputs, masked ? kKeepUv : kNoUv, kVertex);
}

}  // namespace penumbra::texture_gl
