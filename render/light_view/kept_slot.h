// Something that was made, for those who want it again: found while anybody uses it, and kept
// beyond that where a budget has room for it.
//
//   KeptSlot<Tree> slot;
//   slot.Put(tree, budget);
//   if (auto tree = slot.Find()) …
#pragma once

#include <memory>
#include <optional>
#include <utility>

#include "render/math/memory_budget.h"

namespace penumbra {

// T has bytes(), what it takes of a budget. One thread at a time.
template <typename T>
class KeptSlot {
 public:
  // `budget`  outlives the slot; null: it is not kept
  void Put(const std::shared_ptr<const T>& made, MemoryBudget* budget) {
    Release();
    made_ = made;
    auto lease = budget ? budget->Take(made->bytes()) : std::nullopt;
    if (!lease) return;
    lease_.emplace(*std::move(lease));
    kept_ = made;
  }

  // Null: there is none.
  std::shared_ptr<const T> Find() const { return made_.lock(); }

  bool is_kept() const { return kept_ != nullptr; }

  // Keeps it no longer; it is found as long as it is used.
  void Release() {
    kept_.reset();
    lease_.reset();
  }

 private:
  std::weak_ptr<const T> made_;
  std::shared_ptr<const T> kept_;
  std::optional<MemoryBudget::Lease> lease_;
};

}  // namespace penumbra
