// Memory for one texture after another.
#pragma once

#include <malloc.h>

namespace penumbra {

// From now on the allocator keeps what is freed for whoever allocates next: by default it gives
// every texture's memory back to the kernel, and the next texture takes one page fault for every
// 4 KB: a quarter of the time of a small edit. For a program's main to call, before it allocates
// much; up to 64 MB stay with the process at rest.
inline void KeepFreedMemory() {
  constexpr int kMegabyte = 1 << 20;
  mallopt(M_MMAP_THRESHOLD, 32 * kMegabyte);  // the most there is
  mallopt(M_TRIM_THRESHOLD, 64 * kMegabyte);
  mallopt(M_TOP_PAD, kMegabyte);
}

}  // namespace penumbra
