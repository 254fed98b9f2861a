#include "render/technique/soft_texture/hard_shadow.h"

#include <cmath>

#include "render/technique/soft_texture/careful_triangle.h"

namespace penumbra {
namespace {

// Groups of fewer triangles cost less to draw than to test against the box.
constexpr uint32_t kTrianglesWorthCulling = 48;

TexelProjection ScaleToTexels(const ReceiverTransform& map, const ReceiverPatch& receiver) {
  TexelProjection projection{};
  for (int c = 0; c < 3; ++c) {
    projection.x_row[c] = static_cast<float>(map.row_x()[c] * receiver.width);
    projection.y_row[c] = static_cast<float>(map.row_y()[c] * receiver.height);
    projection.w_row[c] = static_cast<float>(map.row_w()[c]);
  }
  return projection;
}

DVec3 CornerOf(const Aabb& box, int corner) {
  return {(corner & 1) ? box.max.x : box.min.x, (corner & 2) ? box.max.y : box.min.y,
          (corner & 4) ? box.max.z : box.min.z};
}

// Whether all corners of the group's box lie beyond one side of the pyramid, or beyond the light.
// Each test is linear in (x, y, w), so what holds for the corners holds for the box.
bool MissesPyramid(const OccluderGroup& group, const ReceiverTransform& map) {
  bool beyond[5] = {true, true, true, true, true};
  for (int corner = 0; corner < 8; ++corner) {
    const DVec3 p = map.FromOffset(CornerOf(group.bounds, corner));
    beyond[0] &= p.x < 0;
    beyond[1] &= p.x > p.z;
    beyond[2] &= p.y < 0;
    beyond[3] &= p.y > p.z;
    beyond[4] &= p.z < 0;
  }
  return beyond[0] || beyond[1] || beyond[2] || beyond[3] || beyond[4];
}

DVec3 VertexOffset(const OccluderSet& occluders, uint32_t vertex) {
  return DVec3(occluders.x[vertex], occluders.y[vertex], occluders.z[vertex]);
}

}  // namespace

void HardShadow::Draw(const OccluderSet& occluders, const SeenOutlines& seen,
                      const LightSample& sample, const ReceiverTransform& map,
                      const TexelWindow& window, ShadowBitmap& bitmap) {
  projection_ = ScaleToTexels(map, receiver_);
  const double near_height = (1.0 - kNearLightW) * std::abs(map.sample_height());
  size_t run_begin = 0;
  const auto end_run = [&](size_t end) {
    if (end > run_begin) DrawRun(occluders, run_begin, end, false, map, window, bitmap);
    run_begin = end + 1;
  };
  for (size_t g = 0; g < occluders.groups.size(); ++g) {
    const OccluderGroup& group = occluders.groups[g];
    const bool near_light = group.max_height > near_height;
    if (group.triangle_count >= kTrianglesWorthCulling && MissesPyramid(group, map)) {
      end_run(g);
    } else if (group.masked) {
      end_run(g);
      for (uint32_t t = 0; t < group.triangle_count; ++t) {
        DrawCarefully(occluders, group.first_triangle + t, group.masked.get(), map, window, bitmap);
      }
    } else if (near_light) {
      end_run(g);
      DrawRun(occluders, g, g + 1, true, map, window, bitmap);
    } else if (group.outline && IsInGuardBand(group, map, window)) {
      end_run(g);
      FlagOutline(occluders, group, seen[g] ? *seen[g] : *group.outline->edges, sample, window);
    }
  }
  end_run(occluders.groups.size());
  if (flags_) FillFromFlags(window, *flags_, bitmap);
}

bool HardShadow::IsInGuardBand(const OccluderGroup& group, const ReceiverTransform& map,
                               const TexelWindow& window) const {
  // As the kernels have it, less what rounding may make of a corner.
  const double guard = kGuardBand - 1;
  for (int corner = 0; corner < 8; ++corner) {
    const DVec3 p = map.FromOffset(CornerOf(group.bounds, corner));
    const double column = receiver_.width * p.x, row = receiver_.height * p.y;
    if (!(p.z >= kNearLightW && column >= -guard * p.z && column <= (window.width + guard) * p.z &&
          row >= (window.row_begin - guard) * p.z && row <= (window.row_end + guard) * p.z)) {
      return false;
    }
  }
  return true;
}

EdgeFlags& HardShadow::FlagsFor(const TexelWindow& window) {
  if (!flags_) flags_.emplace(window.width, window.row_end - window.row_begin);
  return *flags_;
}

void HardShadow::FlagOutline(const OccluderSet& occluders, const OccluderGroup& group,
                             const SilhouetteEdges& edges, const LightSample& sample,
                             const TexelWindow& window) {
  const Outline& outline = *group.outline;
  outline_.Clear();
  const DVec4 seen_from(DVec3(sample.point), sample.at_infinity ? 0.0 : 1.0);
  edges.Find(outline.mesh_from_world * seen_from, outline_);
  const uint32_t first = group.first_vertex;
  FlagEdges({&occluders.x[first], &occluders.y[first], &occluders.z[first]},
            {outline_.from.data(), outline_.to.data(), outline_.weight.data(), outline_.count},
            outline.sign, projection_, window, FlagsFor(window));
}

void HardShadow::DrawRun(const OccluderSet& occluders, size_t begin, size_t end, bool near_light,
                         const ReceiverTransform& map, const TexelWindow& window,
                         ShadowBitmap& bitmap) {
  const OccluderGroup& first = occluders.groups[begin];
  const OccluderGroup& last = occluders.groups[end - 1];
  const uint32_t vertex_count = last.first_vertex + last.vertex_count - first.first_vertex;
  projected_.Reserve(vertex_count);
  ProjectVertices(occluders.x.data() + first.first_vertex, occluders.y.data() + first.first_vertex,
                  occluders.z.data() + first.first_vertex, vertex_count, projection_, projected_);
  const uint32_t t = first.first_triangle;
  const TriangleList triangles{occluders.corner0.data() + t,
                               occluders.corner1.data() + t,
                               occluders.corner2.data() + t,
                               occluders.facing.data() + t,
                               last.first_triangle + last.triangle_count - t,
                               first.first_vertex};
  deferred_.clear();
  if (method_ == VisibilityMethod::kEdgeFlag) {
    FlagTriangles(projected_, triangles, window, near_light, FlagsFor(window), deferred_);
  } else {
    DrawTriangles(projected_, triangles, window, near_light, bitmap, deferred_);
  }
  for (const uint32_t triangle : deferred_) {
    DrawCarefully(occluders, t + triangle, nullptr, map, window, bitmap);
  }
}

void HardShadow::DrawCarefully(const OccluderSet& occluders, uint32_t triangle,
                               const Instance* masked, const ReceiverTransform& map,
                               const TexelWindow& window, ShadowBitmap& bitmap) const {
  const uint32_t corners[3] = {occluders.corner0[triangle], occluders.corner1[triangle],
                               occluders.corner2[triangle]};
  HomogeneousTriangle homogeneous;
  for (int k = 0; k < 3; ++k) {
    homogeneous[k] = map.FromOffset(VertexOffset(occluders, corners[k]));
  }
  const ClippedPolygon polygon = ClipToTexture(homogeneous, receiver_.width, receiver_.height);
  if (!masked) {
    FillPolygon(polygon, window, nullptr, bitmap);
    return;
  }
  const UvAcrossTriangle uv(
      homogeneous, {occluders.uv[corners[0]], occluders.uv[corners[1]], occluders.uv[corners[2]]},
      receiver_.width, receiver_.height);
  const auto opaque = [&](uint32_t column, uint32_t row) {
    return masked->alpha_mask->At(uv.At(column, row)) >= masked->alpha_cutoff;
  };
  FillPolygon(polygon, window, opaque, bitmap);
}

}  // namespace penumbra
