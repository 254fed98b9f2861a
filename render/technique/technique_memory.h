// What a technique keeps from one computation of an artifact to the next, within a budget that all
// artifacts share.
#pragma once

#include <memory>
#include <mutex>

#include "render/math/memory_budget.h"
#include "render/technique/first_pass.h"

namespace penumbra {

class CasterBvhStore;

// What the artifacts of one scene share, for as long as one of them keeps it.
struct SceneMemory {
  std::mutex mutex;
  std::weak_ptr<CasterBvhStore> bvhs;
};

// One artifact's. A technique may put anything of its own there, and must do without what it finds
// missing or of another computation.
struct TechniqueMemory {
  MemoryBudget& budget;
  std::shared_ptr<void> kept{};             // made and read by the artifact's technique alone
  FirstPassPace pace{};                     // of computing everything
  FirstPassPace pace_of_edits{};            // of computing what an edit changed
  std::shared_ptr<SceneMemory> of_scene{};  // null: the artifact shares nothing
};

}  // namespace penumbra
