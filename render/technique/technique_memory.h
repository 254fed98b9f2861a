// What a technique keeps from one computation of an artifact to the next, within a budget that all
// artifacts share.
#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <optional>

#include "render/technique/first_pass.h"

namespace penumbra {

// Bytes that may be kept in all. Any thread may take and give back.
class MemoryBudget {
 public:
  explicit MemoryBudget(size_t bytes) : left_(bytes) {}

  // Bytes taken, given back when it goes. Outlived by its budget.
  class Lease {
   public:
    Lease(Lease&& other) noexcept : budget_(other.budget_), bytes_(other.bytes_) {
      other.budget_ = nullptr;
    }
    Lease& operator=(Lease&&) = delete;
    ~Lease() {
      if (budget_) budget_->left_ += bytes_;
    }

   private:
    friend class MemoryBudget;
    Lease(MemoryBudget& budget, size_t bytes) : budget_(&budget), bytes_(bytes) {}

    MemoryBudget* budget_;
    size_t bytes_;
  };

  // nullopt: there are not as many left.
  std::optional<Lease> Take(size_t bytes) {
    size_t left = left_;
    do {
      if (left < bytes) return std::nullopt;
    } while (!left_.compare_exchange_weak(left, left - bytes));
    return Lease(*this, bytes);
  }

 private:
  std::atomic<size_t> left_;
};

// One artifact's. A technique may put anything of its own there, and must do without what it finds
// missing or of another computation.
struct TechniqueMemory {
  MemoryBudget& budget;
  std::shared_ptr<void> kept{};   // made and read by the artifact's technique alone
  FirstPassPace pace{};           // of computing everything
  FirstPassPace pace_of_edits{};  // of computing what an edit changed
};

}  // namespace penumbra
