// A casting instance as a frame sees it, ready to be drawn from any eye in it.
#pragma once

#include <memory>
#include <stop_token>
#include <vector>

#include "render/artifact/light_view.h"
#include "render/light_view/raster_kernel.h"
#include "render/scene/instance.h"

namespace penumbra {

// A light's frame, sheared so that what is seen at `middle` is straight ahead: single precision is
// relative to what is straight ahead, and the scene may be far to the side.
struct RasterFrame {
  LightFrame frame;
  DVec2 middle{0.0};  // a slope

  DVec3 Sheared(DVec3 q) const { return DVec3(DVec2(q) - q.z * middle, q.z); }
  DVec3 FromWorld(DVec3 p) const { return Sheared(frame.FromWorld(p)); }
};

// A box in a frame.
struct FrameBox {
  Vec3 min, max;
};

class PlacedCaster {
 public:
  // Once stop is requested, of those clusters only that are placed by then.
  PlacedCaster(const RasterFrame& frame, std::shared_ptr<const Instance> instance,
               const std::stop_token& stop = {});

  const RasterFrame& frame() const { return frame_; }
  const Instance& instance() const { return *instance_; }
  bool is_cut() const { return instance_->alpha_mask && !instance_->mesh->uvs().empty(); }
  // Around all of it.
  const FrameBox& bounds() const { return bounds_; }

  // The mesh's clusters; vertices that several of them have are in each.
  size_t cluster_count() const { return boxes_.size(); }
  RasterCluster Cluster(size_t index) const;
  const FrameBox& BoxOf(size_t cluster) const { return boxes_[cluster]; }
  // The mesh's vertex behind each of the cluster's.
  const uint32_t* VerticesOf(size_t cluster) const;
  // In the frame, as exactly as the world's coordinates tell.
  DVec3 PositionOf(uint32_t mesh_vertex) const;

 private:
  FrameBox Place(size_t first, size_t end);

  RasterFrame frame_;
  std::shared_ptr<const Instance> instance_;
  std::vector<float> x_, y_, z_;
  std::vector<FrameBox> boxes_;  // one a cluster
  FrameBox bounds_;
};

}  // namespace penumbra
