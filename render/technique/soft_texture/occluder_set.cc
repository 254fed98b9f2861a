#include "render/technique/soft_texture/occluder_set.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "render/technique/soft_texture/outline_cost.h"

namespace penumbra {
namespace {

struct Corner {
  PlacedVertex at;
  Vec2 uv;
};

// The sign of the projected area of faces towards the light, where the others need not be drawn.
float FacingOf(const Instance& instance, int side) {
  if (instance.alpha_mask || instance.mesh->closure() == MeshClosure::kOpen) return 0;
  const Affine& m = instance.world_from_mesh;
  const double det = glm::dot(DVec3(m[0]), glm::cross(DVec3(m[1]), DVec3(m[2])));
  if (det == 0) return 0;
  return static_cast<float>(side * (det > 0 ? 1 : -1));
}

// Appends one instance after another to a set.
class SetBuilder {
 public:
  explicit SetBuilder(const OccluderFrame& frame) : frame_(frame) {}

  void AddOutlined(std::unique_ptr<const OutlinedOccluder> occluder) {
    set_.outlined.push_back(std::move(occluder));
  }

  void AddFaces(const std::shared_ptr<const Instance>& instance) {
    const Mesh& mesh = *instance->mesh;
    BeginGroup(*instance);
    if (mesh.triangle_count() <= kClusterTriangles) {
      for (uint32_t v = 0; v < mesh.vertex_count(); ++v) PlaceCorner(*instance, v);
      if (!(highest_ > frame_.surface_offset)) return;
      AddPiece(0, mesh.indices());
    } else {
      PlaceClusters(*instance);
      if (!(highest_ > frame_.surface_offset)) return;
      AddClusters(mesh.triangle_clusters());
    }
    if (set_.pieces.size() == pieces_before_) return;
    set_.groups.push_back({.max_height = static_cast<float>(highest_),
                           .masked = instance->alpha_mask ? instance : nullptr});
  }

  OccluderSet Take() {
    for (auto* coordinates : {&set_.x, &set_.y, &set_.z, &set_.facing}) {
      coordinates->resize(coordinates->size() + kMaxLanes);
    }
    for (auto* corners : {&set_.corner0, &set_.corner1, &set_.corner2}) {
      corners->resize(corners->size() + kMaxLanes);
    }
    set_.bounds = BoxLevels(bounds_);
    return std::move(set_);
  }

 private:
  void BeginGroup(const Instance& instance) {
    masked_ = instance.alpha_mask != nullptr;
    if (masked_ && !keep_uv_) {
      keep_uv_ = true;
      set_.uv.resize(set_.x.size());
    }
    corners_.clear();
    seen_.clear();
    lowest_ = std::numeric_limits<double>::infinity();
    highest_ = -lowest_;
    pieces_before_ = set_.pieces.size();
    whole_facing_ = FacingOf(instance, frame_.side);
  }

  void PlaceCorner(const Instance& instance, uint32_t vertex) {
    const Mesh& mesh = *instance.mesh;
    const PlacedVertex at = frame_.Place(instance.world_from_mesh, mesh.positions()[vertex]);
    corners_.push_back({at, masked_ ? mesh.uvs()[vertex] : Vec2(0.0f)});
    lowest_ = std::min(lowest_, at.height);
    highest_ = std::max(highest_, at.height);
  }

  // The corners of all clusters in the region, cluster by cluster.
  void PlaceClusters(const Instance& instance) {
    const TriangleClusters& clusters = instance.mesh->triangle_clusters();
    const auto take = [&](uint32_t c) {
      seen_.push_back(c);
      for (uint32_t v = clusters.first_vertex[c]; v < clusters.first_vertex[c + 1]; ++v) {
        PlaceCorner(instance, clusters.vertices[v]);
      }
    };
    if (!frame_.region) {
      for (uint32_t c = 0; c < clusters.size(); ++c) take(c);
      return;
    }
    const ShadowRegion region =
        frame_.region->InMesh(instance.world_from_mesh, instance.mesh->bounds());
    clusters.tree.Visit([&](const Aabb& box) { return region.MayMeetByFaces(box); }, take);
  }

  void AddClusters(const TriangleClusters& clusters) {
    size_t first_corner = 0;
    for (const uint32_t c : seen_) {
      indices_.clear();
      for (uint32_t t = clusters.first_triangle[c]; t < clusters.first_triangle[c + 1]; ++t) {
        for (int k = 0; k < 3; ++k) indices_.push_back(clusters.corners[size_t{3} * t + k]);
      }
      AddPiece(first_corner, indices_);
      first_corner += clusters.first_vertex[c + 1] - clusters.first_vertex[c];
    }
  }

  // Triangles between corners_, numbered from `first_corner`. Where the plane cuts anything of the
  // instance that is drawn, all is drawn whichever way it faces.
  void AddPiece(size_t first_corner, std::span<const uint32_t> indices) {
    piece_ = {.first_vertex = static_cast<uint32_t>(set_.x.size()),
              .first_triangle = static_cast<uint32_t>(set_.corner0.size()),
              .vertex_count = 0,
              .triangle_count = 0,
              .group = static_cast<uint32_t>(set_.groups.size())};
    box_ = {};
    const bool cut = !(lowest_ > frame_.surface_offset);
    facing_ = cut ? 0 : whole_facing_;
    // Of many vertices most belong to no triangle; one by one only those that do are copied.
    const bool has_loose_vertices = seen_.empty() && corners_.size() > indices.size();
    const Corner* const corners = corners_.data() + first_corner;
    if (cut || has_loose_vertices) {
      AddCutTriangles(corners, indices);
    } else {
      AddWholeTriangles(corners, indices);
    }
    piece_.vertex_count = static_cast<uint32_t>(set_.x.size()) - piece_.first_vertex;
    piece_.triangle_count = static_cast<uint32_t>(set_.corner0.size()) - piece_.first_triangle;
    if (piece_.triangle_count == 0) return;
    set_.pieces.push_back(piece_);
    bounds_.push_back(box_);
  }

  uint32_t AddVertex(const Corner& corner) {
    set_.x.push_back(corner.at.offset.x);
    set_.y.push_back(corner.at.offset.y);
    set_.z.push_back(corner.at.offset.z);
    if (keep_uv_) set_.uv.push_back(corner.uv);
    box_.Add(corner.at.offset);
    return static_cast<uint32_t>(set_.x.size() - 1);
  }

  void AddTriangle(uint32_t a, uint32_t b, uint32_t c) {
    set_.corner0.push_back(a);
    set_.corner1.push_back(b);
    set_.corner2.push_back(c);
    set_.facing.push_back(facing_);
  }

  void AddWholeTriangles(const Corner* corners, std::span<const uint32_t> indices) {
    uint32_t count = 0;
    for (const uint32_t i : indices) count = std::max(count, i + 1);
    for (uint32_t c = 0; c < count; ++c) AddVertex(corners[c]);
    const uint32_t first = piece_.first_vertex;
    for (size_t t = 0; t < indices.size(); t += 3) {
      AddTriangle(first + indices[t], first + indices[t + 1], first + indices[t + 2]);
    }
  }

  // Where an edge crosses the plane. Always from the upper corner, so that both triangles of an
  // edge get the same point.
  Corner Crossing(const Corner& a, const Corner& b) const {
    const Corner& high = a.at.height > b.at.height ? a : b;
    const Corner& low = a.at.height > b.at.height ? b : a;
    const double t = (high.at.height - frame_.surface_offset) / (high.at.height - low.at.height);
    const DVec3 from(high.at.offset), to(low.at.offset);
    return {{Vec3(from + t * (to - from)), frame_.surface_offset},
            high.uv + static_cast<float>(t) * (low.uv - high.uv)};
  }

  void AddCutTriangles(const Corner* corners, std::span<const uint32_t> indices) {
    for (size_t t = 0; t < indices.size(); t += 3) {
      std::array<uint32_t, 4> polygon{};
      size_t size = 0;
      for (int k = 0; k < 3; ++k) {
        const Corner& from = corners[indices[t + k]];
        const Corner& to = corners[indices[t + (k + 1) % 3]];
        const bool from_above = from.at.height > frame_.surface_offset;
        if (from_above) polygon[size++] = AddVertex(from);
        if (from_above != (to.at.height > frame_.surface_offset)) {
          polygon[size++] = AddVertex(Crossing(from, to));
        }
      }
      for (size_t k = 2; k < size; ++k) AddTriangle(polygon[0], polygon[k - 1], polygon[k]);
    }
  }

  const OccluderFrame& frame_;
  bool keep_uv_ = false;
  // The instance that is being added.
  bool masked_ = false;
  float whole_facing_ = 0, facing_ = 0;
  double lowest_ = 0, highest_ = 0;
  size_t pieces_before_ = 0;
  std::vector<Corner> corners_;
  std::vector<uint32_t> seen_, indices_;  // clusters, and corners of one's triangles
  OccluderPiece piece_{};
  Aabb box_;
  std::vector<Aabb> bounds_;  // of the pieces
  OccluderSet set_;
};

}  // namespace

namespace {

using Caster = std::shared_ptr<const Instance>;

// Calls `visit` with every instance that casts and may matter.
template <typename Visit>
void ForEachCaster(const Scene& scene, const OccluderFrame& frame, const CasterChoice& choice,
                   const Visit& visit) {
  const auto visit_caster = [&](const Caster& instance) {
    if (instance && instance->casts && instance->mesh->triangle_count() > 0) visit(instance);
  };
  if (choice.ids && !choice.all_but_ids) {
    for (const std::string& id : *choice.ids) visit_caster(scene.FindInstance(id));
  } else if (!frame.region) {
    for (const auto& [id, instance] : scene.instances()) {
      if (choice.Has(id)) visit_caster(instance);
    }
  } else {
    scene.casters().Visit([&](const Aabb& box) { return frame.region->MayMeetByFaces(box); },
                          [&](const Caster& instance) {
                            if (choice.Has(instance->id)) visit_caster(instance);
                          });
  }
}

}  // namespace

OccluderSet PrepareOccluders(const Scene& scene, const OccluderFrame& frame,
                             const TextureView& texture, OutlineRule outlines,
                             const CasterChoice& choice, const std::stop_token& stop) {
  SetBuilder builder(frame);
  std::vector<std::unique_ptr<const OutlinedOccluder>> candidates;
  ShadowRectangle rectangle(texture);
  double saving = 0;
  ForEachCaster(scene, frame, choice, [&](const Caster& instance) {
    if (stop.stop_requested()) return;
    // Of so few faces none could be saved.
    const bool is_small =
        OutlineSavingNs({.faces_in_region = instance->mesh->triangle_count()}) < 0;
    const bool is_tried = outlines == OutlineRule::kWherePossible ||
                          (outlines == OutlineRule::kWhereCheaper && !is_small);
    auto outlined = is_tried ? OutlinedOccluder::Create(instance, frame) : nullptr;
    const bool is_cheaper = outlined && outlines == OutlineRule::kWhereCheaper;
    const double saved = is_cheaper ? OutlineSavingNs(WorkOf(*outlined)) : 0;
    if (!outlined || saved < 0) return builder.AddFaces(instance);
    saving += saved;
    rectangle.Add(outlined->bounds());
    candidates.push_back(std::move(outlined));
  });
  const bool pays = outlines != OutlineRule::kWhereCheaper || saving > FillNs(rectangle.Texels());
  for (auto& candidate : candidates) {
    if (pays) {
      builder.AddOutlined(std::move(candidate));
    } else {
      builder.AddFaces(candidate->shared_instance());
    }
  }
  return builder.Take();
}

OccluderSet PrepareOccluder(const std::shared_ptr<const Instance>& instance,
                            const OccluderFrame& frame) {
  SetBuilder builder(frame);
  builder.AddFaces(instance);
  return builder.Take();
}

}  // namespace penumbra
