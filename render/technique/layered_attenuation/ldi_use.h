// How much memory building an LDI takes.
//
//   LdiLease lease(use, bytes);   // until it ends
//   if (auto status = CheckLdiBytes(use->bytes, limits.max_bytes); !status.ok()) return status;
#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <utility>

#include "absl/status/status.h"

namespace penumbra {

// What the builders of an LDI's faces, and who feeds them, have taken in all.
struct LdiUse {
  std::atomic<size_t> bytes{0};
};

// Some of it.
class LdiLease {
 public:
  LdiLease(std::shared_ptr<LdiUse> use, size_t bytes) : use_(std::move(use)), bytes_(bytes) {
    use_->bytes += bytes_;
  }
  LdiLease(LdiLease&& other) noexcept
      : use_(std::move(other.use_)), bytes_(std::exchange(other.bytes_, 0)) {}
  LdiLease& operator=(LdiLease&& other) noexcept {
    std::swap(use_, other.use_);
    std::swap(bytes_, other.bytes_);
    return *this;
  }
  ~LdiLease() {
    if (use_) use_->bytes -= bytes_;
  }

  void Resize(size_t bytes) {
    use_->bytes += bytes - bytes_;  // modulo 2^64, where it becomes less
    bytes_ = bytes;
  }

 private:
  std::shared_ptr<LdiUse> use_;
  size_t bytes_;
};

// Errors  kResourceExhausted QUOTA_LDI_BYTES, "resolution": more than `most`
absl::Status CheckLdiBytes(size_t bytes, size_t most);

}  // namespace penumbra
