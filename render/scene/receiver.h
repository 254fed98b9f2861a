// The patches that shadows are computed on.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "absl/status/statusor.h"
#include "render/math/vec.h"
#include "render/scene/coverage_mask.h"
#include "render/scene/instance.h"

namespace penumbra {

// origin + u·edge_u + v·edge_v for u, v in [0, 1]. The front is edge_u × edge_v.
struct Parallelogram {
  Vec3 origin{0.0f};
  Vec3 edge_u{1, 0, 0};
  Vec3 edge_v{0, 0, -1};

  friend bool operator==(const Parallelogram&, const Parallelogram&) = default;

  Vec3 At(Vec2 uv) const { return origin + uv.x * edge_u + uv.y * edge_v; }
  Vec3 normal() const { return Vec3(glm::normalize(glm::cross(DVec3(edge_u), DVec3(edge_v)))); }
};

// The smallest parallelogram around an instance all of whose vertices lie in one plane; inside are
// its triangles.
struct PlanarInstance {
  std::string instance_id;

  friend bool operator==(const PlanarInstance&, const PlanarInstance&) = default;
};

// The half u + v ≤ 1 of a parallelogram.
struct Triangle {
  Vec3 corner{0.0f};
  Vec3 edge_u{1, 0, 0};  // from the corner to the second one
  Vec3 edge_v{0, 0, -1};

  friend bool operator==(const Triangle&, const Triangle&) = default;
};

// A simple polygon, convex or not, in one plane. Its patch is the smallest parallelogram around it;
// seen from the front its vertices run counter-clockwise.
struct PlanarPolygon {
  std::vector<Vec3> vertices;  // 3 or more, world; the last one is joined to the first

  friend bool operator==(const PlanarPolygon&, const PlanarPolygon&) = default;
};

// One planar surface of an instance (planar_surfaces.h): that to which a triangle belongs.
struct PlanarSurface {
  std::string instance_id;
  uint32_t triangle = 0;  // of the instance's mesh

  friend bool operator==(const PlanarSurface&, const PlanarSurface&) = default;
};

using ReceiverShape =
    std::variant<Parallelogram, PlanarInstance, Triangle, PlanarPolygon, PlanarSurface>;

struct Receiver {
  std::string id;  // as for instances; unique among a scene's receivers
  ReceiverShape shape;
  uint32_t width = 0;   // texels along edge_u; 0: from its length (texture_size.h)
  uint32_t height = 0;  // texels along edge_v; likewise
  // Lit from whichever side light comes; otherwise from the front alone. Visibility is the same for
  // both, this is about radiance.
  bool two_sided = true;
  Vec3 reflectance{1.0f};  // diffuse, linear RGB in [0, 1], multiplied into radiance textures
  // Of sides that are chosen by the receiver's size.
  float texels_per_metre = 0.0f;  // 0: kTexelsPerMetre
  uint32_t max_auto_side = 0;     // texels; 0: kMaxAutoSide

  friend bool operator==(const Receiver&, const Receiver&) = default;
};

// The instance that the receiver lies on; null for one that stands by itself.
const std::string* InstanceOf(const Receiver& receiver);

// A receiver with its place in the world known: a parallelogram with an H×W grid of texels whose
// centres are At((i + ½)/W, (j + ½)/H); row 0 is at v = 0.
struct ReceiverPatch {
  Parallelogram patch;
  uint32_t width = 0;
  uint32_t height = 0;
  bool two_sided = true;
  Vec3 reflectance{1.0f};
  // The two below are known while computing; an artifact has a CoverageMask instead.
  std::shared_ptr<const PlanarRegion> region;  // what of the patch is the receiver; null: all of it
  double deviation_m = 0.0;  // how far the surface that it stands for leaves the patch's plane

  friend bool operator==(const ReceiverPatch&, const ReceiverPatch&);

  Vec2 UvOfTexel(uint32_t i, uint32_t j) const {
    return {(static_cast<float>(i) + 0.5f) / static_cast<float>(width),
            (static_cast<float>(j) + 0.5f) / static_cast<float>(height)};
  }
  Vec3 TexelCenter(uint32_t i, uint32_t j) const { return patch.At(UvOfTexel(i, j)); }
};

// The (u, v) of the point's projection along the patch's normal; least squares in the patch's
// plane.
DVec2 UvOnPatch(const Parallelogram& patch, DVec3 point);

// The smallest parallelogram that holds `instance`, its front on the side of the faces.
//
// Errors  kFailedPrecondition, reason NOT_PLANAR: a vertex is further from the plane through its
//         first corner than 1e-4 of the extent, or the instance covers no area.
absl::StatusOr<Parallelogram> BoundingParallelogram(const Instance& instance);

}  // namespace penumbra
