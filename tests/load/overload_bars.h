// What is asked for of a server that is sent more than it can carry, and of the load that shows it.
//
//   Bars bars;
//   Judge(findings, bars);        // prints each beside its bar
//   return bars.status();
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "render/engine/engine.h"
#include "tests/load/outcome.h"

namespace penumbra::load {

class Bars {
 public:
  void AtLeast(const char* name, double value, double bar) {
    Print(name, value, bar, value >= bar);
  }
  void AtMost(const char* name, double value, double bar) { Print(name, value, bar, value <= bar); }
  // Errors  kFailedPrecondition: which were missed
  absl::Status status() const;

 private:
  void Print(const char* name, double value, double bar, bool is_met);

  std::string missed_;
};

struct OverloadFindings {
  double maximum_per_s = 0;  // that the server carries
  double times = 0;          // so much more was to be sent
  bool is_deaf = false;      // clients send although they were told to wait
  Outcome over;
  std::optional<double> seconds_to_normal;  // none: never
  size_t lost = 0;                          // commits that were acknowledged and are not there
};

void Judge(const OverloadFindings& findings, Bars& bars);

// Of scenes of which each had one commit before, by how many acknowledged commits they fall short.
size_t LostCommits(const std::map<std::string, size_t>& acknowledged_by_scene,
                   const std::vector<SceneInfo>& scenes);

}  // namespace penumbra::load
