#include <type_traits>

#include "render/technique/soft_texture/soft_texture.h"
#include "render/technique/technique.h"

namespace penumbra {
namespace {

const Technique& InstanceFor(const SoftTextureParams&) {
  static const SoftTexture technique;
  return technique;
}

}  // namespace

const Technique& TechniqueFor(const TechniqueParams& params) {
  return std::visit([](const auto& p) -> const Technique& { return InstanceFor(p); }, params);
}

}  // namespace penumbra
