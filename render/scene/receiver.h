// The patches that shadows are computed on.
#pragma once

#include <cstdint>
#include <string>
#include <variant>

#include "absl/status/statusor.h"
#include "render/math/vec.h"
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

// The smallest parallelogram around an instance all of whose vertices lie in one plane.
struct PlanarInstance {
  std::string instance_id;

  friend bool operator==(const PlanarInstance&, const PlanarInstance&) = default;
};

struct Receiver {
  std::string id;  // as for instances; unique among a scene's receivers
  std::variant<Parallelogram, PlanarInstance> shape;
  uint32_t width = 256;   // texels along edge_u, > 0
  uint32_t height = 256;  // texels along edge_v, > 0
  // Lit from whichever side light comes; otherwise from the front alone. Visibility is the same for
  // both, this is about radiance.
  bool two_sided = true;
  Vec3 reflectance{1.0f};  // diffuse, linear RGB in [0, 1], multiplied into radiance textures

  friend bool operator==(const Receiver&, const Receiver&) = default;
};

// A receiver with its place in the world known: a parallelogram with an H×W grid of texels whose
// centres are At((i + ½)/W, (j + ½)/H); row 0 is at v = 0.
struct ReceiverPatch {
  Parallelogram patch;
  uint32_t width = 0;
  uint32_t height = 0;
  bool two_sided = true;
  Vec3 reflectance{1.0f};

  friend bool operator==(const ReceiverPatch&, const ReceiverPatch&) = default;

  Vec2 UvOfTexel(uint32_t i, uint32_t j) const {
    return {(static_cast<float>(i) + 0.5f) / static_cast<float>(width),
            (static_cast<float>(j) + 0.5f) / static_cast<float>(height)};
  }
  Vec3 TexelCenter(uint32_t i, uint32_t j) const { return patch.At(UvOfTexel(i, j)); }
};

// The smallest parallelogram that holds `instance`, its front on the side of the faces.
//
// Errors  kFailedPrecondition, reason NOT_PLANAR: a vertex is further from the plane through its
//         first corner than 1e-4 of the extent, or the instance covers no area.
absl::StatusOr<Parallelogram> BoundingParallelogram(const Instance& instance);

}  // namespace penumbra
