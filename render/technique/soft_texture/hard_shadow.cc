#include "render/technique/soft_texture/hard_shadow.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "render/technique/soft_texture/careful_triangle.h"

namespace penumbra {
namespace {

// Fewer edges are looked at for one sample before the lists for all are there.
constexpr size_t kEdgesWorthLists = 2048;

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

DVec3 VertexOffset(const OccluderSet& occluders, uint32_t vertex) {
  return DVec3(occluders.x[vertex], occluders.y[vertex], occluders.z[vertex]);
}

}  // namespace

void HardShadow::FindOutlines(std::span<const LightSample> lenders, const OccluderSet& occluders,
                              std::span<const SeenOutline> seen) {
  lenders_.assign(lenders.begin(), lenders.end());
  list_of_.clear();
  std::vector<LightSample> unequal;
  for (const LightSample& lender : lenders) {
    const auto known = std::ranges::find(unequal, lender.point, &LightSample::point);
    list_of_.push_back(static_cast<size_t>(known - unequal.begin()));
    if (known == unequal.end()) unequal.push_back(lender);
  }
  found_.resize(seen.size());
  for (size_t o = 0; o < seen.size(); ++o) {
    const SilhouetteEdges& edges = seen[o].edges();
    const bool together = lenders.size() > 1 && edges.shared_edge_count() >= kEdgesWorthLists;
    found_[o].resize(together ? unequal.size() : 0);
    if (!together) continue;
    std::vector<DVec4> viewpoints;
    for (const LightSample& lender : unequal) {
      viewpoints.push_back(occluders.outlined[o]->InMesh(lender));
    }
    for (SilhouetteList& list : found_[o]) list.Clear();
    edges.FindEach(viewpoints, found_[o]);
  }
}

void HardShadow::Draw(const OccluderSet& occluders, std::span<const SeenOutline> seen,
                      const LightSample& sample, size_t neighbour, const ReceiverTransform& map,
                      const TexelWindow& window, ShadowBitmap& bitmap) {
  const View view{.sample = sample,
                  .map = map,
                  .window = window,
                  .projection = ScaleToTexels(map, receiver_),
                  .sides = UnitBoxSides(map, window, receiver_.height),
                  .near_height = (1.0 - kNearLightW) * std::abs(map.sample_height()),
                  .bitmap = bitmap};
  DrawPieces(occluders, view);
  for (size_t o = 0; o < occluders.outlined.size(); ++o) {
    const OutlinedOccluder& occluder = *occluders.outlined[o];
    if (rules_.cull && MissesUnitBox(occluder.bounds(), view.sides)) continue;
    if (occluder.max_height() > view.near_height || !IsInGuardBand(occluder.bounds(), view)) {
      DrawPieces(occluder.FaceByFace(), view);
    } else {
      DrawOutlined(occluder, seen[o], OutlineOf(o, neighbour, occluders, seen[o]), view);
    }
  }
  if (flags_) FillFromFlags(window, *flags_, bitmap);
}

void HardShadow::DrawPieces(const OccluderSet& occluders, const View& view) {
  if (rules_.cull) {
    occluders.bounds.Select(view.sides, visible_);
  } else {
    visible_.resize(occluders.pieces.size());
    std::iota(visible_.begin(), visible_.end(), 0u);
  }
  size_t begin = 0, end = 0;  // of the run so far
  bool near_light = false;
  const auto end_run = [&] {
    if (end > begin) DrawRun(occluders, begin, end, near_light, view);
    begin = end;
  };
  for (const uint32_t p : visible_) {
    const OccluderPiece& piece = occluders.pieces[p];
    const OccluderGroup& group = occluders.groups[piece.group];
    if (group.masked) {
      for (uint32_t t = 0; t < piece.triangle_count; ++t) {
        DrawCarefully(occluders, piece.first_triangle + t, group.masked.get(), view);
      }
      continue;
    }
    const bool is_near = group.max_height > view.near_height;
    if (p != end || is_near != near_light) {
      end_run();
      begin = p;
      near_light = is_near;
    }
    end = p + 1;
  }
  end_run();
}

bool HardShadow::IsInGuardBand(const Aabb& box, const View& view) const {
  // As the kernels have it, less what rounding may make of a corner.
  const double guard = kGuardBand - 1;
  const TexelWindow& window = view.window;
  for (int corner = 0; corner < 8; ++corner) {
    const DVec3 p = view.map.FromOffset(CornerOf(box, corner));
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

const SilhouetteList& HardShadow::OutlineOf(size_t o, size_t neighbour,
                                            const OccluderSet& occluders, const SeenOutline& seen) {
  if (!found_[o].empty()) return found_[o][list_of_[neighbour]];
  outline_.Clear();
  seen.edges().Find(occluders.outlined[o]->InMesh(lenders_[neighbour]), outline_);
  return outline_;
}

void HardShadow::DrawOutlined(const OutlinedOccluder& occluder, const SeenOutline& seen,
                              const SilhouetteList& outline, const View& view) {
  FlagEdges({seen.x.data(), seen.y.data(), seen.z.data()},
            {outline.from.data(), outline.to.data(), outline.weight.data(), outline.count},
            occluder.sign(), view.projection, view.window, FlagsFor(view.window));
}

void HardShadow::DrawRun(const OccluderSet& occluders, size_t begin, size_t end, bool near_light,
                         const View& view) {
  const OccluderPiece& first = occluders.pieces[begin];
  const OccluderPiece& last = occluders.pieces[end - 1];
  const uint32_t vertex_count = last.first_vertex + last.vertex_count - first.first_vertex;
  projected_.Reserve(vertex_count);
  ProjectVertices(occluders.x.data() + first.first_vertex, occluders.y.data() + first.first_vertex,
                  occluders.z.data() + first.first_vertex, vertex_count, view.projection,
                  projected_);
  const uint32_t t = first.first_triangle;
  const TriangleList triangles{occluders.corner0.data() + t,
                               occluders.corner1.data() + t,
                               occluders.corner2.data() + t,
                               occluders.facing.data() + t,
                               last.first_triangle + last.triangle_count - t,
                               first.first_vertex};
  deferred_.clear();
  if (rules_.method == VisibilityMethod::kEdgeFlag) {
    FlagTriangles(projected_, triangles, view.window, near_light, FlagsFor(view.window), deferred_);
  } else {
    DrawTriangles(projected_, triangles, view.window, near_light, view.bitmap, deferred_);
  }
  for (const uint32_t triangle : deferred_) DrawCarefully(occluders, t + triangle, nullptr, view);
}

void HardShadow::DrawCarefully(const OccluderSet& occluders, uint32_t triangle,
                               const Instance* masked, const View& view) const {
  const uint32_t corners[3] = {occluders.corner0[triangle], occluders.corner1[triangle],
                               occluders.corner2[triangle]};
  HomogeneousTriangle homogeneous;
  for (int k = 0; k < 3; ++k) {
    homogeneous[k] = view.map.FromOffset(VertexOffset(occluders, corners[k]));
  }
  const ClippedPolygon polygon = ClipToTexture(homogeneous, receiver_.width, receiver_.height);
  if (!masked) {
    FillPolygon(polygon, view.window, nullptr, view.bitmap);
    return;
  }
  const UvAcrossTriangle uv(
      homogeneous, {occluders.uv[corners[0]], occluders.uv[corners[1]], occluders.uv[corners[2]]},
      receiver_.width, receiver_.height);
  const auto opaque = [&](uint32_t column, uint32_t row) {
    return masked->alpha_mask->At(uv.At(column, row)) >= masked->alpha_cutoff;
  };
  FillPolygon(polygon, view.window, opaque, view.bitmap);
}

}  // namespace penumbra
