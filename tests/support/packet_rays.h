// The peer of coherence-based sampling: Embree tracing all samples of a point in packets, through a
// hierarchy of its own over the triangles of a scene.
//
//   PacketRays peer(scene);
//   std::vector<uint16_t> visible = peer.VisibleFrom(points, {.light = light, .side = 16}, arena);
#pragma once

#include <embree3/rtcore.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "render/scene/scene.h"
#include "render/technique/coherent_raytrace/light_square.h"
#include "render/technique/coherent_raytrace/surface_points.h"
#include "tbb/task_arena.h"

namespace penumbra::testing {

struct PacketRaySettings {
  AreaLight light;
  uint32_t side = 16;        // side² samples, a multiple of 16
  uint64_t seed = 1;         // of the samples, as in SamplingSettings
  float surface_offset = 0;  // m
  bool is_coherent = false;  // Embree's flag
};

class PacketRays {
 public:
  // Meshes without masks.
  explicit PacketRays(const Scene& scene);

  // How many of the samples each point sees: cells of 4 × 4 a packet. Samples below the horizon or
  // on the light's back cost no ray.
  std::vector<uint16_t> VisibleFrom(const SurfacePoints& points, const PacketRaySettings& settings,
                                    tbb::task_arena& arena) const;

 private:
  std::shared_ptr<RTCDeviceTy> device_;
  std::shared_ptr<RTCSceneTy> top_;
};

}  // namespace penumbra::testing
