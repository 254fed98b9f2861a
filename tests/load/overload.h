// More than a server can carry: what it still does, how soon it refuses the rest, what that takes
// of memory, and how soon all is well again.
#pragma once

#include <string>

#include "absl/status/status.h"

namespace penumbra::load {

struct OverloadPlan {
  std::string server;
  int clients = 200;
  int scenes = 50;
  double times = 4;      // the load that it can carry
  double seconds = 60;   // for so long
  bool is_deaf = false;  // clients send although they were told to wait
  int server_pid = 0;    // whose memory is looked at; 0: nobody's
  double max_memory_mb = 1024;
};

// Finds by a ramp what the server can carry, sends `times` as much, and then half of it. Prints
// what came of it beside what is asked for.
//
// Errors  what the server says that does not let it begin; kFailedPrecondition: a bar was missed
absl::Status RunOverload(const OverloadPlan& plan);

}  // namespace penumbra::load
