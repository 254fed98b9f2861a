#include "render/technique/shadow_volume/volume_hash.h"

#include "render/scene/hashed_bytes.h"
#include "render/scene/scene_hash.h"

namespace penumbra {

ContentHash HashOfVolume(const ContentHash& casters, const AreaLight& light,
                         const ShadowVolumeOptions& options) {
  HashedBytes bytes;
  bytes.Put(casters);
  bytes.Put(HashOf(light));
  bytes.Put(options.resolution);
  bytes.Put(options.edges.thresholds.has_value());
  const EdgeThresholds thresholds = options.edges.thresholds.value_or(EdgeThresholds{});
  bytes.Put(thresholds.low);
  bytes.Put(thresholds.high);
  bytes.Put(thresholds.second);
  bytes.Put(thresholds.dangling);
  bytes.Put(options.edges.follows_dangling);
  bytes.Put(options.has_instance_edges);
  bytes.Put(options.vectorizes);
  bytes.Put(static_cast<uint32_t>(options.reconstruction));
  bytes.Put(options.bias_px);
  return bytes.Hash();
}

}  // namespace penumbra
