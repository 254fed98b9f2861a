// Bytes on the GPU, counted before they are asked for: a driver without memory answers late and
// leaves GL undefined, and a software device has the whole process killed.
//
//   auto lease = context.TakeMemory(bytes, "gl::Buffer");
//   if (!lease.ok()) return lease.status();   // and keep it with what takes them
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>

namespace penumbra::gl {

// What a context's textures and buffers may take in all, by their texels and bytes: what a driver
// spends besides is not known.
class MemoryBudget {
 public:
  explicit MemoryBudget(size_t limit) : limit_(limit) {}

  size_t limit() const { return limit_; }
  size_t used() const { return used_; }

  // Bytes taken, given back when it goes. Move-only; may outlive all but the budget, which it
  // shares.
  class Lease {
   public:
    Lease() = default;
    Lease(Lease&& other) noexcept { Swap(other); }
    Lease& operator=(Lease&& other) noexcept {
      Swap(other);
      return *this;
    }
    ~Lease() {
      if (budget_) budget_->used_ -= bytes_;
    }

   private:
    friend class MemoryBudget;
    Lease(std::shared_ptr<MemoryBudget> budget, size_t bytes)
        : budget_(std::move(budget)), bytes_(bytes) {}
    void Swap(Lease& other) noexcept {
      std::swap(budget_, other.budget_);
      std::swap(bytes_, other.bytes_);
    }

    std::shared_ptr<MemoryBudget> budget_;
    size_t bytes_ = 0;
  };

  // nullopt: there are not as many left.
  static std::optional<Lease> Take(const std::shared_ptr<MemoryBudget>& budget, size_t bytes) {
    size_t used = budget->used_;
    do {
      if (bytes > budget->limit_ - used) return std::nullopt;
    } while (!budget->used_.compare_exchange_weak(used, used + bytes));
    return Lease(budget, bytes);
  }

 private:
  const size_t limit_;
  std::atomic<size_t> used_ = 0;  // never more than limit_
};

}  // namespace penumbra::gl
