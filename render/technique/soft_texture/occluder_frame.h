// Where occluders are laid out for drawing: relative to a receiver.
#pragma once

#include <functional>
#include <set>
#include <string>

#include "render/math/vec.h"
#include "render/scene/receiver.h"
#include "render/scene/shadow_region.h"

namespace penumbra {

// A corner of a triangle as it is drawn.
struct PlacedVertex {
  Vec3 offset;    // from the receiver's origin, in world directions
  double height;  // metres over the receiver's plane, on the frame's side
};

// One side of a receiver. What is within `surface_offset` metres of its plane does not cast.
//
// Coordinates are metres from the receiver's origin in world directions, so that a surface in the
// receiver's plane keeps its full precision.
struct OccluderFrame {
  OccluderFrame(const Parallelogram& patch, int to_side, double offset)
      : origin(patch.origin),
        up(glm::normalize(glm::cross(DVec3(patch.edge_u), DVec3(patch.edge_v))) *
           static_cast<double>(to_side)),
        side(to_side),
        surface_offset(offset) {}

  PlacedVertex Place(const Affine& world_from_mesh, Vec3 position) const {
    const DVec3 offset = DVec3(TransformPoint(world_from_mesh, position)) - origin;
    return {Vec3(offset), glm::dot(up, offset)};
  }

  DVec3 origin;
  DVec3 up;  // unit length
  int side;  // +1: the receiver's front, −1: its back
  double surface_offset;
  // Where an occluder must be to matter; null: anywhere. Outlives the frame.
  const ShadowRegion* region = nullptr;
};

// Which of the instances that cast are drawn.
struct CasterChoice {
  const std::set<std::string>* ids = nullptr;  // null: all
  bool all_but_ids = false;                    // otherwise those of `ids` alone

  bool Has(const std::string& id) const { return !ids || ids->contains(id) != all_but_ids; }
};

}  // namespace penumbra
