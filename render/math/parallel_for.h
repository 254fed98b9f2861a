// Parallel loops by oneTBB.
//
//   RunIn(arena, [&] { ParallelFor(rows, [&](uint32_t row) { Shade(row); }); });
//
// The same as task_arena::execute() and tbb::parallel_for(), except that ThreadSanitizer is told
// what it cannot see, because Debian's oneTBB is not instrumented: all that came before a loop is
// seen by its iterations, and all that they did is seen after it. Nothing is said about iterations
// among themselves, so that races between them are still found (docs/adr/0007).
#pragma once

#include "render/math/hand_over.h"
#include "tbb/parallel_for.h"
#include "tbb/task_arena.h"

namespace penumbra {

// Calls `body(range)` for parts of `range`, one of TBB's ranges, that together are all of it.
template <typename Range, typename Body>
void ParallelForRange(const Range& range, const Body& body) {
  HandOver fork;
  HandOver join;
  fork.Give();
  tbb::parallel_for(range, [&](const Range& part) {
    fork.Take();
    body(part);
    join.Give();
  });
  join.Take();
}

// Calls `body(i)` for each i in [0, count).
template <typename Index, typename Body>
void ParallelFor(Index count, const Body& body) {
  if (count == 1) {  // not worth a task
    body(Index{0});
    return;
  }
  ParallelForRange(tbb::blocked_range<Index>(0, count), [&](const tbb::blocked_range<Index>& part) {
    for (Index i = part.begin(); i < part.end(); ++i) body(i);
  });
}

// Calls `body()` where `arena` bounds the threads of its loops. It may run on another thread.
template <typename Body>
void RunIn(tbb::task_arena& arena, const Body& body) {
  HandOver enter;
  HandOver leave;
  enter.Give();
  arena.execute([&] {
    enter.Take();
    body();
    leave.Give();
  });
  leave.Take();
}

}  // namespace penumbra
