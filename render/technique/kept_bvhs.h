// The hierarchies that rays of an artifact's next computation will want again.
#pragma once

#include <memory>

#include "render/light_view/caster_bvh.h"
#include "render/technique/technique_memory.h"

namespace penumbra {

// In the artifact's memory, if it has one: what an edit leaves in its place is not built again. Of
// techniques that keep nothing else there.
inline std::shared_ptr<CasterBvhs> KeptBvhs(TechniqueMemory* memory) {
  if (memory == nullptr) return std::make_shared<CasterBvhs>();
  if (memory->kept == nullptr) memory->kept = std::make_shared<CasterBvhs>();
  return std::static_pointer_cast<CasterBvhs>(memory->kept);
}

}  // namespace penumbra
