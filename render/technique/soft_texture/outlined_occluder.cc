#include "render/technique/soft_texture/outlined_occluder.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "render/math/parallel_for.h"
#include "render/scene/caster_tree.h"
#include "render/technique/soft_texture/coverage_kernel.h"
#include "render/technique/soft_texture/occluder_set.h"

namespace penumbra {
namespace {

// A mesh keeps 64 bytes a triangle to find its outline with, and takes three microseconds a
// triangle to make them; nobody can stop that, and no budget counts it.
constexpr size_t kMostTrianglesForAnOutline = 1u << 20;

// Fewer edges are looked at for every sample sooner than once for all.
constexpr size_t kEdgesWorthSelecting = 1024;

// Whether every vertex of a triangle is further than the surface offset above the plane.
bool LiesAbove(const Instance& instance, const OccluderFrame& frame) {
  const Mesh& mesh = *instance.mesh;
  const auto is_above = [&](uint32_t v) {
    return frame.Place(instance.world_from_mesh, mesh.positions()[v]).height > frame.surface_offset;
  };
  if (mesh.triangle_count() <= kClusterTriangles) {
    return std::all_of(mesh.indices().begin(), mesh.indices().end(), is_above);
  }
  // The height of a point of the mesh is linear in it; rounding moves vertices by this.
  const Affine& m = instance.world_from_mesh;
  const DVec3 place(m[3]);
  DVec3 slope;
  double size = glm::length(place) + glm::length(frame.origin);
  for (int c = 0; c < 3; ++c) {
    const DVec3 column(m[c]);
    slope[c] = glm::dot(frame.up, column);
    size += glm::length(column) *
            std::max(std::abs(mesh.bounds().min[c]), std::abs(mesh.bounds().max[c]));
  }
  const double height = glm::dot(frame.up, place - frame.origin);
  const double above = frame.surface_offset + std::ldexp(size, -20);
  const TriangleClusters& clusters = mesh.triangle_clusters();
  bool all = true;
  clusters.tree.Visit(
      [&](const Aabb& box) {
        const DVec3 middle(box.center()), half(0.5f * box.extent());
        return all && !(height + glm::dot(slope, middle) - glm::dot(glm::abs(slope), half) > above);
      },
      [&](uint32_t c) {
        const auto begin = clusters.vertices.begin();
        all = all && std::all_of(begin + clusters.first_vertex[c],
                                 begin + clusters.first_vertex[c + 1], is_above);
      });
  return all;
}

void PlaceAll(const OutlinedOccluder& occluder, std::span<const uint32_t> vertices,
              SeenOutline& outline) {
  const size_t count = vertices.size();
  for (auto* values : {&outline.x, &outline.y, &outline.z}) values->resize(count + kMaxLanes);
  const Instance& instance = occluder.instance();
  for (size_t v = 0; v < count; ++v) {
    const Vec3 at = occluder.frame()
                        .Place(instance.world_from_mesh, instance.mesh->positions()[vertices[v]])
                        .offset;
    outline.x[v] = at.x;
    outline.y[v] = at.y;
    outline.z[v] = at.z;
  }
}

SeenOutline OutlineSeenFrom(const OutlinedOccluder& occluder,
                            std::span<const LightSample> samples) {
  const Mesh& mesh = *occluder.instance().mesh;
  SeenOutline outline;
  outline.all = &mesh.silhouette_edges();
  if (outline.all->shared_edge_count() < kEdgesWorthSelecting) {
    std::vector<uint32_t> vertices(mesh.vertex_count());
    std::iota(vertices.begin(), vertices.end(), 0u);
    PlaceAll(occluder, vertices, outline);
    return outline;
  }
  std::vector<DVec4> viewpoints;
  for (const LightSample& sample : samples) viewpoints.push_back(occluder.InMesh(sample));
  outline.selected = outline.all->SeenFrom(ViewBall::Around(viewpoints));
  PlaceAll(occluder, outline.selected->RenumberVertices(mesh.vertex_count()), outline);
  return outline;
}

}  // namespace

std::unique_ptr<const OutlinedOccluder> OutlinedOccluder::Create(
    std::shared_ptr<const Instance> instance, const OccluderFrame& frame) {
  if (instance->mesh->triangle_count() > kMostTrianglesForAnOutline) return nullptr;
  if (instance->alpha_mask) return nullptr;
  DMat4 world_from_mesh(1.0);
  for (int column = 0; column < 4; ++column) {
    world_from_mesh[column] = DVec4(DVec3(instance->world_from_mesh[column]), column == 3);
  }
  const DMat4 mesh_from_world = glm::inverse(world_from_mesh);
  for (int column = 0; column < 4; ++column) {
    // Flat, or so nearly that its inverse says nothing.
    if (!(glm::length(mesh_from_world[column]) < 1e12)) return nullptr;
  }
  if (!LiesAbove(*instance, frame)) return nullptr;

  std::unique_ptr<OutlinedOccluder> occluder(new OutlinedOccluder(std::move(instance), frame));
  occluder->mesh_from_world_ = mesh_from_world;
  occluder->sign_ = (glm::determinant(world_from_mesh) > 0) == (frame.side > 0) ? -1 : 1;
  const Aabb world = CasterBounds(*occluder->instance_);
  const DVec3 low(world.min), high(world.max);
  // What single precision makes of the differences.
  const DVec3 slack = 0x1.0p-22 * (glm::abs(low) + glm::abs(high) + glm::abs(frame.origin));
  occluder->bounds_ = {Vec3(low - frame.origin - slack), Vec3(high - frame.origin + slack)};
  const DVec3 middle(occluder->bounds_.center()), half(0.5f * occluder->bounds_.extent());
  occluder->max_height_ = static_cast<float>(glm::dot(frame.up, middle) +
                                             (1 + 1e-6) * glm::dot(glm::abs(frame.up), half));
  return occluder;
}

OutlinedOccluder::OutlinedOccluder(std::shared_ptr<const Instance> instance,
                                   const OccluderFrame& frame)
    : instance_(std::move(instance)), frame_(frame) {}

OutlinedOccluder::~OutlinedOccluder() = default;

const OccluderSet& OutlinedOccluder::FaceByFace() const {
  std::call_once(faces_once_, [this] {
    faces_ = std::make_unique<const OccluderSet>(PrepareOccluder(instance_, frame_));
  });
  return *faces_;
}

std::vector<SeenOutline> OutlinesSeenFrom(
    std::span<const std::unique_ptr<const OutlinedOccluder>> occluders,
    std::span<const LightSample> samples, tbb::task_arena& arena) {
  std::vector<SeenOutline> seen(occluders.size());
  if (seen.empty()) return seen;
  RunIn(arena, [&] {
    ParallelFor(seen.size(), [&](size_t i) { seen[i] = OutlineSeenFrom(*occluders[i], samples); });
  });
  return seen;
}

}  // namespace penumbra
