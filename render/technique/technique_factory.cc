#include <type_traits>

#include "render/technique/coherent_raytrace/coherent_raytrace.h"
#include "render/technique/layered_attenuation/layered_attenuation.h"
#include "render/technique/shadow_volume/shadow_volumes.h"
#include "render/technique/shadow_width/shadow_width.h"
#include "render/technique/soft_texture/soft_texture.h"
#include "render/technique/technique.h"

namespace penumbra {
namespace {

const Technique& InstanceFor(const SoftTextureParams&) {
  static const SoftTexture technique;
  return technique;
}
const Technique& InstanceFor(const LayeredAttenuationParams&) {
  static const LayeredAttenuation technique;
  return technique;
}
const Technique& InstanceFor(const CoherentRaytraceParams&) {
  static const CoherentRaytrace technique;
  return technique;
}
const Technique& InstanceFor(const ShadowWidthParams&) {
  static const ShadowWidth technique;
  return technique;
}

const Technique& InstanceFor(const ShadowVolumeParams&) {
  static const ShadowVolumes technique;
  return technique;
}

}  // namespace

const Technique& TechniqueFor(const TechniqueParams& params) {
  return std::visit([](const auto& p) -> const Technique& { return InstanceFor(p); }, params);
}

}  // namespace penumbra
