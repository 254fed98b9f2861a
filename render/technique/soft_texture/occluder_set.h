// The triangles that can block light on one side of a receiver, laid out for the drawing kernels.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <stop_token>
#include <vector>

#include "render/math/vec.h"
#include "render/scene/scene.h"
#include "render/technique/soft_texture/box_levels.h"
#include "render/technique/soft_texture/occluder_frame.h"
#include "render/technique/soft_texture/outline_cost.h"
#include "render/technique/soft_texture/outlined_occluder.h"

namespace penumbra {

// A run of triangles that lie close together, and all of their vertices: what is left out or drawn
// as one. Small meshes are one piece, large ones a piece for each cluster.
struct OccluderPiece {
  uint32_t first_vertex, first_triangle;
  uint32_t vertex_count, triangle_count;
  uint32_t group;
};

// What is common to the pieces of one instance.
struct OccluderGroup {
  float max_height = 0;                    // metres over the receiver's plane, on the set's side
  std::shared_ptr<const Instance> masked;  // has an alpha mask; null: opaque
};

// V vertices and T triangles in P pieces, one piece after another. Coordinates are those of the
// frame.
struct OccluderSet {
  std::vector<float> x, y, z;                       // V, padded for whole vectors
  std::vector<uint32_t> corner0, corner1, corner2;  // T, padded
  // +1 or −1: the sign of the projected area with which the triangle faces the light, where faces
  // that look away need not be drawn. 0: draw both.
  std::vector<float> facing;  // T, padded
  std::vector<Vec2> uv;       // V if any group is masked, otherwise empty
  std::vector<OccluderGroup> groups;
  std::vector<OccluderPiece> pieces;
  BoxLevels bounds;  // of the pieces
  // Drawn from their outlines instead.
  std::vector<std::unique_ptr<const OutlinedOccluder>> outlined;

  bool empty() const { return pieces.empty() && outlined.empty(); }
};

// The parts of the casting instances of `choice` that are more than the frame's surface offset from
// the receiver's plane, on the frame's side, and in the frame's region, with what else is in their
// clusters.
//
// Faces that look away from the light are marked as superfluous where the mesh is closed and the
// plane does not cut it: they cover just what those towards it do.
//
// Once `stop` is requested the set is left unfinished.
//
// `texture`  the receiver, and one of the samples: where and how large shadows are
//
// Cost  O(√[3]{N} + V + T) of N instances, where few of them are in the region
OccluderSet PrepareOccluders(const Scene& scene, const OccluderFrame& frame,
                             const TextureView& texture, OutlineRule outlines,
                             const CasterChoice& choice, const std::stop_token& stop = {});

// The same of one instance, face by face.
OccluderSet PrepareOccluder(const std::shared_ptr<const Instance>& instance,
                            const OccluderFrame& frame);

}  // namespace penumbra
