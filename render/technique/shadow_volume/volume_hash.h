// What a volume is made from, as a hash: equal inputs make equal volumes.
#pragma once

#include "render/scene/area_light.h"
#include "render/scene/content_hash.h"
#include "render/technique/shadow_volume/shadow_volume_options.h"

namespace penumbra {

// casters  of the scene, or of one instance with whatever else its volume depends on
ContentHash HashOfVolume(const ContentHash& casters, const AreaLight& light,
                         const ShadowVolumeOptions& options);

}  // namespace penumbra
