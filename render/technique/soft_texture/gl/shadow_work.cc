#include "render/technique/soft_texture/gl/shadow_work.h"

namespace penumbra::texture_gl {

ShadowWork::ShadowWork(const ShadowRequest& r, const std::stop_token& stop)
    : request(&r),
      front(glm::normalize(
          glm::cross(DVec3(r.receiver.patch.edge_u), DVec3(r.receiver.patch.edge_v)))),
      casters(CastersOn(r.scene, r.receiver)),
      maps(SampleMaps(r.receiver, r.samples, r.surface_offset, stop)) {
  if (!r.light) return;
  light_samples = LightSamplesForGpu(*r.light, r.samples, r.receiver.patch);
  emitter = EmitterOf(*r.light);
}

void CopyFromPage(const Page& page, std::span<const float> pixels, size_t channels,
                  std::span<const ShadowWork> works, std::span<ShadowSums> sums) {
  for (const Tile& tile : page.tiles) {
    const uint32_t width = works[tile.receiver].request->receiver.width;
    ShadowSums& to = sums[tile.receiver];
    for (uint32_t row = 0; row < tile.rows; ++row) {
      const float* pixel = &pixels[(size_t{tile.y + row} * page.width + tile.x) * channels];
      const size_t first = size_t{tile.first_row + row} * width;
      for (size_t t = first; t < first + width; ++t, pixel += channels) {
        to.hidden[t] = static_cast<uint16_t>(pixel[channels - 1]);
        if (!to.radiance.empty()) to.radiance[t] = Vec3(pixel[0], pixel[1], pixel[2]);
      }
    }
  }
}

}  // namespace penumbra::texture_gl
