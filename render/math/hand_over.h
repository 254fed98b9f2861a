// Tells ThreadSanitizer of an order between threads that a library keeps and that it cannot see,
// because Debian's libraries are not instrumented (docs/adr/0007).
//
//   writer: … place.Give();      // then the library wakes the reader
//   reader: place.Take(); …
//
// Without the sanitizer it is nothing.
#pragma once

#ifdef __SANITIZE_THREAD__
#include <sanitizer/tsan_interface.h>
#endif

namespace penumbra {

// A point in the program that some threads leave something at for others.
class HandOver {
 public:
#ifdef __SANITIZE_THREAD__
  void Give() { __tsan_release(&place_); }
  void Take() { __tsan_acquire(&place_); }

 private:
  char place_ = 0;
#else
  void Give() {}
  void Take() {}
#endif
};

}  // namespace penumbra
