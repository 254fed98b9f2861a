// Makes large allocations fail, on one thread and for a while.
//
//   const ScarceMemory scarce(1000);
//   std::vector<char> large(1001);   // throws std::bad_alloc
#pragma once

#include <cstddef>

namespace penumbra::testing {

class ScarceMemory {
 public:
  explicit ScarceMemory(size_t largest_bytes);
  ~ScarceMemory();
  ScarceMemory(const ScarceMemory&) = delete;
  ScarceMemory& operator=(const ScarceMemory&) = delete;
};

}  // namespace penumbra::testing
