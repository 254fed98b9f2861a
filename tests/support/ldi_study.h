// Attenuation LDIs against rays: the scenes, the points, the peers.
//
//   LdiStudy study(OnAFloor(instances));
//   AttenuationLdi ldi = study.Build({.samples = 64});
//   LdiError error = study.Compare(ldi, {.samples = 64});
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "render/light_view/caster_bvh.h"
#include "render/scene/light_sample.h"
#include "render/scene/scene.h"
#include "render/technique/layered_attenuation/ldi_passes.h"
#include "tbb/task_arena.h"

namespace penumbra::testing {

// `instances` on a floor of a few times their width, which casts too, below a rectangle that shines
// down, "light".
std::shared_ptr<const Scene> OnAFloor(std::vector<Instance> instances);

// Each triangle of the instances' meshes in nine or eleven parts, which together are the triangle:
// ten times as many, or one less.
std::vector<Instance> Subdivided(const std::vector<Instance>& instances);

// What a camera that holds the scene sees: a point a pixel, and its normal, towards the camera.
struct CameraPoints {
  uint32_t width = 0, height = 0;
  std::vector<Vec3> points, normals;
  std::vector<uint8_t> is_hit;
};

struct LdiError {
  size_t points = 0;
  double mean = 0, bias = 0, p99 = 0;  // |Δ|, Δ and |Δ| of attenuation
  std::vector<float> traced, found;    // a pixel
};

class LdiStudy {
 public:
  LdiStudy(std::shared_ptr<const Scene> scene, int threads);

  const Scene& scene() const { return *scene_; }
  const CameraPoints& camera_points() const { return camera_points_; }
  size_t triangle_count() const { return bvh_->triangle_count(); }
  bool is_drawn_by_rays() const { return source_ != sources_[0].get(); }  // or partly

  // Instead of the way that was the quicker one when the study began.
  void DrawBy(bool rays) { source_ = sources_[rays ? 1 : 0].get(); }

  AttenuationLdi Build(const LdiOptions& options);
  // What rays from the camera's points to the same samples tell.
  LdiError Compare(const AttenuationLdi& ldi, const LdiOptions& options);
  // The peer: packets of rays from the LDI's own layers to the same samples. Returns how many meet
  // nothing.
  size_t TraceFromLayers(const AttenuationLdi& ldi, const LdiOptions& options);

 private:
  void ChooseSource();
  void FindCameraPoints(const Aabb& bounds);
  float Traced(Vec3 point, Vec3 normal, const std::vector<LightSample>& samples) const;
  std::vector<LightSample> Samples(const LdiOptions& options) const;

  tbb::task_arena arena_;
  const std::shared_ptr<const Scene> scene_;
  const AreaLight light_;
  CasterBvhs bvhs_;
  std::shared_ptr<const CasterBvh> bvh_;
  std::vector<std::unique_ptr<DepthSource>> sources_;
  DepthSource* source_ = nullptr;  // the quicker
  CameraPoints camera_points_;
  float ray_offset_ = 0;  // m
};

double MeanLayers(const AttenuationLdi& ldi);  // of pixels that have any

}  // namespace penumbra::testing
