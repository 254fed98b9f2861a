#include "tests/support/scarce_memory.h"

#include <cstdlib>
#include <limits>
#include <new>

namespace penumbra::testing {
namespace {

constexpr size_t kNoLimit = std::numeric_limits<size_t>::max();
thread_local size_t largest_allocation = kNoLimit;

}  // namespace

ScarceMemory::ScarceMemory(size_t largest_bytes) { largest_allocation = largest_bytes; }
ScarceMemory::~ScarceMemory() { largest_allocation = kNoLimit; }

}  // namespace penumbra::testing

// Of the whole test program.
void* operator new(size_t size, const std::nothrow_t&) noexcept {
  return size > penumbra::testing::largest_allocation ? nullptr : std::malloc(size);
}
void* operator new(size_t size) {
  void* memory = operator new(size, std::nothrow);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, size_t) noexcept { std::free(memory); }
void operator delete(void* memory, const std::nothrow_t&) noexcept { std::free(memory); }
