// What the GL method is asked to draw, what follows from it, and what comes back.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "render/math/vec.h"
#include "render/scene/area_light.h"
#include "render/scene/light_sample.h"
#include "render/scene/receiver.h"
#include "render/scene/scene.h"
#include "render/technique/soft_texture/gl/caster.h"
#include "render/technique/soft_texture/gl/occluder_glsl.h"
#include "render/technique/soft_texture/gl/pages.h"
#include "render/technique/soft_texture/gl/sample_term.h"

namespace penumbra::texture_gl {

// What is drawn for one receiver; all of it outlives the call.
struct ShadowRequest {
  const Scene& scene;
  const ReceiverPatch& receiver;
  double surface_offset = 0;  // as for OcclusionCounter
  std::span<const LightSample> samples;
  const AreaLight* light = nullptr;  // that `samples` are of, where radiance is wanted
};

// H·W each, row by row; `radiance` only where it was asked for.
struct ShadowSums {
  std::vector<uint16_t> hidden;  // samples that occluders hide
  // Sum over the visible samples of their terms of equation (3.2), each taken to stand for all of
  // the light: over the number of samples it is the radiance.
  std::vector<Vec3> radiance;
};

// A request with what follows from it.
struct ShadowWork {
  const ShadowRequest* request;
  DVec3 front;  // unit normal
  std::vector<Caster> casters;
  std::vector<GpuSampleMap> maps;             // one a sample
  std::vector<GpuLightSample> light_samples;  // likewise, where radiance is wanted
  GpuEmitter emitter;

  ShadowWork(const ShadowRequest& request, const std::stop_token& stop);

  size_t pass_count() const { return (maps.size() + kSamplesPerPass - 1) / kSamplesPerPass; }
};

// The part of a sample's array that is for a pass; empty past the last.
template <typename T>
std::span<const T> OfPass(const std::vector<T>& values, size_t pass) {
  const size_t first = pass * kSamplesPerPass;
  if (first >= values.size()) return {};
  return std::span(values).subspan(first, std::min<size_t>(kSamplesPerPass, values.size() - first));
}

// Copies a page's pixels to the receivers that they belong to.
//
// Shapes  page of H×W pixels of 1 channel (hidden) or 4 (radiance, hidden), row 0 first
void CopyFromPage(const Page& page, std::span<const float> pixels, size_t channels,
                  std::span<const ShadowWork> works, std::span<ShadowSums> sums);

}  // namespace penumbra::texture_gl
