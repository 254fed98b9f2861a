// Numbers out of a step's payload, the least byte first; zeros past its end.
//
//   PayloadNumbers numbers(step.payload);
//   const size_t at = numbers.Next(4) % bytes.size();
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace penumbra::fuzzing {

class PayloadNumbers {
 public:
  explicit PayloadNumbers(std::string_view payload) : rest_(payload) {}

  uint64_t Next(size_t bytes) {
    uint64_t number = 0;
    for (size_t i = 0; i < bytes && !rest_.empty(); ++i) {
      number |= uint64_t{static_cast<uint8_t>(rest_[0])} << (8 * i);
      rest_.remove_prefix(1);
    }
    return number;
  }
  std::string_view rest() const { return rest_; }

 private:
  std::string_view rest_;
};

}  // namespace penumbra::fuzzing
