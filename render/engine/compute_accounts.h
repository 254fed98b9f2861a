// What an engine asks about principals, and tells of them: whose jobs weigh how much, and what they
// took.
#pragma once

#include <string>

namespace penumbra {

class ComputeAccounts {
 public:
  struct Standing {
    double weight = 1;  // share of a scene's jobs, against other principals; > 0
    // Its jobs run only while no others wait.
    bool gives_way = false;
  };

  virtual ~ComputeAccounts() = default;

  // Both are called from the engine's threads and must not block or call the engine.
  virtual Standing StandingOf(const std::string& principal) = 0;
  // A job for it took so long, by the engine's clock; of a job for several, its part.
  virtual void Charge(const std::string& principal, double ms) = 0;
};

}  // namespace penumbra
