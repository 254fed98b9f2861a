// Memory that many may keep, within one bound.
//
//   MemoryBudget budget(size_t{256} << 20);
//   if (auto lease = budget.Take(bytes)) …  // keep what takes them, and the lease with it
#pragma once

#include <atomic>
#include <cstddef>
#include <optional>

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

}  // namespace penumbra
