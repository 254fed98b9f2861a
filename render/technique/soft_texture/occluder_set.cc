#include "render/technique/soft_texture/occluder_set.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "render/math/parallel_for.h"
#include "render/technique/soft_texture/coverage_kernel.h"

namespace penumbra {
namespace {

struct Corner {
  Vec3 offset;    // from the receiver's origin
  double height;  // over its plane
  Vec2 uv;
};

// A mesh keeps 100 bytes a triangle to find its outline with, and takes a microsecond a triangle to
// find them; nobody can stop that, and no budget counts it.
constexpr size_t kMostTrianglesForAnOutline = 1u << 20;

// Appends one instance after another to a set.
class SetBuilder {
 public:
  SetBuilder(const Parallelogram& patch, int side, double surface_offset,
             const OutlineRule& outlines)
      : origin_(patch.origin),
        up_(glm::normalize(glm::cross(DVec3(patch.edge_u), DVec3(patch.edge_v))) *
            static_cast<double>(side)),
        side_(side),
        surface_offset_(surface_offset),
        outlines_(outlines) {}

  void Add(const std::shared_ptr<const Instance>& instance) {
    const Mesh& mesh = *instance->mesh;
    const bool masked = instance->alpha_mask != nullptr;
    if (masked && !keep_uv_) {
      keep_uv_ = true;
      set_.uv.resize(set_.x.size());
    }
    corners_.clear();
    corners_.reserve(mesh.vertex_count());
    double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
    for (size_t v = 0; v < mesh.vertex_count(); ++v) {
      const Vec3 world = TransformPoint(instance->world_from_mesh, mesh.positions()[v]);
      const DVec3 offset = DVec3(world) - origin_;
      const double height = glm::dot(up_, offset);
      corners_.push_back({Vec3(offset), height, masked ? mesh.uvs()[v] : Vec2(0.0f)});
      lowest = std::min(lowest, height);
      highest = std::max(highest, height);
    }
    if (!(highest > surface_offset_)) return;

    group_ = {.first_vertex = static_cast<uint32_t>(set_.x.size()),
              .first_triangle = static_cast<uint32_t>(set_.corner0.size()),
              .bounds = {},
              .max_height = static_cast<float>(highest),
              .masked = masked ? instance : nullptr};
    const bool cut = !(lowest > surface_offset_);
    const float facing = Facing(*instance, cut);
    // Of many vertices most belong to no triangle; one by one only those that do are copied.
    const bool has_loose_vertices = mesh.vertex_count() > mesh.indices().size();
    if (cut || has_loose_vertices) {
      AddCutTriangles(mesh.indices(), facing);
    } else {
      AddWholeTriangles(mesh.indices(), facing);
      group_.outline = OutlineOf(*instance);
    }
    group_.vertex_count = static_cast<uint32_t>(set_.x.size()) - group_.first_vertex;
    group_.triangle_count = static_cast<uint32_t>(set_.corner0.size()) - group_.first_triangle;
    if (group_.triangle_count > 0) set_.groups.push_back(group_);
  }

  OccluderSet Take() {
    for (auto* coordinates : {&set_.x, &set_.y, &set_.z, &set_.facing}) {
      coordinates->resize(coordinates->size() + kMaxLanes);
    }
    for (auto* corners : {&set_.corner0, &set_.corner1, &set_.corner2}) {
      corners->resize(corners->size() + kMaxLanes);
    }
    return std::move(set_);
  }

 private:
  std::optional<Outline> OutlineOf(const Instance& instance) const {
    const size_t triangles = instance.mesh->triangle_count();
    if (instance.alpha_mask || triangles < outlines_.min_triangles) return {};
    if (triangles > kMostTrianglesForAnOutline) return {};
    DMat4 world_from_mesh(1.0);
    for (int column = 0; column < 4; ++column) {
      world_from_mesh[column] = DVec4(DVec3(instance.world_from_mesh[column]), column == 3);
    }
    const DMat4 mesh_from_world = glm::inverse(world_from_mesh);
    const double det = glm::determinant(world_from_mesh);
    for (int column = 0; column < 4; ++column) {
      // Flat, or so nearly that its inverse says nothing.
      if (!(glm::length(mesh_from_world[column]) < 1e12)) return {};
    }
    return Outline{.mesh = instance.mesh,
                   .edges = &instance.mesh->silhouette_edges(),
                   .mesh_from_world = mesh_from_world,
                   .sign = (det > 0) == (side_ > 0) ? -1 : 1};
  }

  float Facing(const Instance& instance, bool cut) const {
    if (instance.alpha_mask || cut || instance.mesh->closure() == MeshClosure::kOpen) return 0;
    const Affine& m = instance.world_from_mesh;
    const double det = glm::dot(DVec3(m[0]), glm::cross(DVec3(m[1]), DVec3(m[2])));
    if (det == 0) return 0;
    return static_cast<float>(side_ * (det > 0 ? 1 : -1));
  }

  uint32_t AddVertex(const Corner& corner) {
    set_.x.push_back(corner.offset.x);
    set_.y.push_back(corner.offset.y);
    set_.z.push_back(corner.offset.z);
    if (keep_uv_) set_.uv.push_back(corner.uv);
    group_.bounds.Add(corner.offset);
    return static_cast<uint32_t>(set_.x.size() - 1);
  }

  void AddTriangle(uint32_t a, uint32_t b, uint32_t c, float facing) {
    set_.corner0.push_back(a);
    set_.corner1.push_back(b);
    set_.corner2.push_back(c);
    set_.facing.push_back(facing);
  }

  void AddWholeTriangles(std::span<const uint32_t> indices, float facing) {
    for (const Corner& corner : corners_) AddVertex(corner);
    const uint32_t first = group_.first_vertex;
    for (size_t t = 0; t < indices.size(); t += 3) {
      AddTriangle(first + indices[t], first + indices[t + 1], first + indices[t + 2], facing);
    }
  }

  // Where an edge crosses the plane. Always from the upper corner, so that both triangles of an
  // edge get the same point.
  Corner Crossing(const Corner& a, const Corner& b) const {
    const Corner& high = a.height > b.height ? a : b;
    const Corner& low = a.height > b.height ? b : a;
    const double t = (high.height - surface_offset_) / (high.height - low.height);
    return {Vec3(DVec3(high.offset) + t * (DVec3(low.offset) - DVec3(high.offset))),
            surface_offset_, high.uv + static_cast<float>(t) * (low.uv - high.uv)};
  }

  void AddCutTriangles(std::span<const uint32_t> indices, float facing) {
    for (size_t t = 0; t < indices.size(); t += 3) {
      std::array<uint32_t, 4> polygon{};
      size_t size = 0;
      for (int k = 0; k < 3; ++k) {
        const Corner& from = corners_[indices[t + k]];
        const Corner& to = corners_[indices[t + (k + 1) % 3]];
        const bool from_above = from.height > surface_offset_;
        if (from_above) polygon[size++] = AddVertex(from);
        if (from_above != (to.height > surface_offset_)) {
          polygon[size++] = AddVertex(Crossing(from, to));
        }
      }
      for (size_t k = 2; k < size; ++k) {
        AddTriangle(polygon[0], polygon[k - 1], polygon[k], facing);
      }
    }
  }

  DVec3 origin_, up_;
  int side_;
  double surface_offset_;
  OutlineRule outlines_;
  bool keep_uv_ = false;
  std::vector<Corner> corners_;
  OccluderGroup group_;
  OccluderSet set_;
};

// Fewer edges are looked at for every sample sooner than once for all.
constexpr size_t kEdgesWorthSelecting = 1024;

// A ball around the samples as the mesh sees them.
ViewBall BallAround(std::span<const LightSample> samples, const DMat4& mesh_from_world) {
  const auto in_mesh = [&](const LightSample& sample) {
    return mesh_from_world * DVec4(DVec3(sample.point), sample.at_infinity ? 0.0 : 1.0);
  };
  ViewBall ball;
  for (const LightSample& sample : samples) ball.center += in_mesh(sample);
  ball.center /= static_cast<double>(samples.size());
  for (const LightSample& sample : samples) {
    ball.radius = std::max(ball.radius, glm::length(DVec3(in_mesh(sample) - ball.center)));
  }
  return ball;
}

}  // namespace

SeenOutlines OutlinesSeenFrom(const OccluderSet& occluders, std::span<const LightSample> samples,
                              tbb::task_arena& arena) {
  SeenOutlines seen(occluders.groups.size());
  std::vector<size_t> worth;
  for (size_t g = 0; g < seen.size() && samples.size() > 1; ++g) {
    const std::optional<Outline>& outline = occluders.groups[g].outline;
    if (outline && outline->edges->shared_edge_count() >= kEdgesWorthSelecting) worth.push_back(g);
  }
  if (worth.empty()) return seen;
  RunIn(arena, [&] {
    ParallelFor(worth.size(), [&](size_t i) {
      const Outline& outline = *occluders.groups[worth[i]].outline;
      seen[worth[i]] = std::make_unique<const SilhouetteEdges>(
          outline.edges->SeenFrom(BallAround(samples, outline.mesh_from_world)));
    });
  });
  return seen;
}

OccluderSet PrepareOccluders(const Scene& scene, const Parallelogram& patch, int side,
                             double surface_offset, const OutlineRule& outlines,
                             const CasterFilter& casters, const std::stop_token& stop) {
  SetBuilder builder(patch, side, surface_offset, outlines);
  for (const auto& [id, instance] : scene.instances()) {
    if (stop.stop_requested()) break;
    if (instance->casts && (!casters || casters(id))) builder.Add(instance);
  }
  return builder.Take();
}

}  // namespace penumbra
