// Turns Ctrl-C and SIGTERM into a stop request, so that a command ends in order: what it made on a
// server is deleted, what it measured is printed. The second signal ends the process.
//
//   Interrupt interrupt;  // before any other thread starts
//   ComputeOnce(engine, scene, spec, {.stop = interrupt.token()});
#pragma once

#include <stop_token>
#include <thread>

namespace penumbra {

class Interrupt {
 public:
  Interrupt();
  ~Interrupt();

  std::stop_token token() const { return source_.get_token(); }

 private:
  std::stop_source source_;
  std::jthread waiter_;
};

}  // namespace penumbra
