// An instance's triangles as Embree takes them, for any number of hierarchies.
//
//   PlacedTriangles triangles(instance, device, stop);
//   rtcAttachGeometry(scene, triangles.geometry());
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <stop_token>

#include "render/scene/instance.h"

struct RTCDeviceTy;
struct RTCFilterFunctionNArguments;
struct RTCGeometryTy;

namespace penumbra {

// Where the instance is, in single precision; rays meet no holes of its mask. Outlives the
// hierarchies.
class PlacedTriangles {
 public:
  // Not whole if stop is requested, or if Embree has no memory, which its device tells.
  PlacedTriangles(std::shared_ptr<const Instance> instance, RTCDeviceTy* device,
                  const std::stop_token& stop);
  PlacedTriangles(const PlacedTriangles&) = delete;  // Embree knows its place

  const Instance& instance() const { return *instance_; }
  RTCGeometryTy* geometry() const { return geometry_.get(); }
  size_t bytes() const;

 private:
  void Place(const std::stop_token& stop);
  bool IsThere(uint32_t triangle, float u, float v) const;
  // Drops the hits where the mask has a hole.
  static void Filter(const RTCFilterFunctionNArguments* args);

  std::shared_ptr<const Instance> instance_;
  std::shared_ptr<RTCGeometryTy> geometry_;
};

}  // namespace penumbra
