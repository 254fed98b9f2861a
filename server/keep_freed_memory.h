// Memory for one texture after another.
#pragma once

#include <malloc.h>

namespace penumbra {

// From now on the allocator keeps what is freed for whoever allocates next: by default it gives
// every texture's memory back to the kernel, and the next texture takes one page fault for every
// 4 KB: a quarter of the time of a small edit. For the main of a program that serves for long,
// before it allocates much. Up to 16 MB at the end of each thread's heap stay with the process at
// rest, and what is free between blocks in use; blocks of 16 MB and more still go back at once.
inline void KeepFreedMemory() {
  constexpr int kMegabyte = 1 << 20;
  mallopt(M_MMAP_THRESHOLD, 16 * kMegabyte);
  mallopt(M_TRIM_THRESHOLD, 16 * kMegabyte);
  mallopt(M_TOP_PAD, kMegabyte);
}

}  // namespace penumbra
