// The hierarchies that rays of a scene's next computations will want again.
#pragma once

#include <memory>
#include <mutex>

#include "render/light_view/caster_bvh.h"
#include "render/light_view/caster_bvh_store.h"
#include "render/technique/technique.h"

namespace penumbra {

// Those that all artifacts of the scene share: as far as the budget goes, what an edit leaves in
// its place is not built again, nor for another light. Of techniques that keep nothing else in the
// artifact's memory; others say where.
inline CasterBvhs KeptBvhs(const ComputeContext& context, std::shared_ptr<void>* where = nullptr) {
  TechniqueMemory* const memory = context.memory;
  if (memory == nullptr) return CasterBvhs(context.stop);
  std::shared_ptr<void>& kept = where == nullptr ? memory->kept : *where;
  if (kept == nullptr) {
    auto store = std::make_shared<CasterBvhStore>(&memory->budget);
    if (memory->of_scene != nullptr) {
      const std::lock_guard lock(memory->of_scene->mutex);
      if (auto shared = memory->of_scene->bvhs.lock()) store = std::move(shared);
      memory->of_scene->bvhs = store;
    }
    kept = std::move(store);
  }
  return CasterBvhs(context.stop, std::static_pointer_cast<CasterBvhStore>(kept));
}

}  // namespace penumbra
