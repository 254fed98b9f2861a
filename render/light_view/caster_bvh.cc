#include "render/light_view/caster_bvh.h"

#include <utility>

#include "render/light_view/caster_bvh_store.h"

namespace penumbra {

CasterBvhs::CasterBvhs(std::stop_token stop, std::shared_ptr<CasterBvhStore> store)
    : stop_(std::move(stop)),
      store_(store ? std::move(store) : std::make_shared<CasterBvhStore>(nullptr)) {}

std::shared_ptr<const CasterBvh> CasterBvhs::Of(const Scene& scene, Instances which) const {
  return store_->Of(scene, which, stop_);
}

std::shared_ptr<const CasterBvh> CasterBvhs::Flat(const Scene& scene) const {
  return store_->Flat(scene, stop_);
}

size_t CasterBvhs::built() const { return store_->built(); }

}  // namespace penumbra
