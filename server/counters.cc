#include "server/counters.h"

namespace penumbra {

prometheus::Histogram::BucketBoundaries ServerCounters::Seconds() {
  // A small edit's artifact takes a millisecond, a final picture minutes.
  return {0.0001, 0.00025, 0.0005, 0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1,
          0.25,   0.5,     1,      2.5,   5,      10,    30,   60,    300,  3600};
}

prometheus::Histogram::BucketBoundaries ServerCounters::Bytes() {
  prometheus::Histogram::BucketBoundaries bounds;
  for (double bytes = 1024; bytes <= 64.0 * (1 << 30); bytes *= 4) bounds.push_back(bytes);
  return bounds;
}

void ServerCounters::ObserveCompute(std::string_view technique, double seconds) {
  compute_seconds.Add({{"technique", std::string(technique)}}, Seconds()).Observe(seconds);
}

void ServerCounters::ObserveCall(const std::string& method, const std::string& code,
                                 double seconds) {
  call_seconds.Add({{"method", method}}, Seconds()).Observe(seconds);
  calls.Add({{"method", method}, {"code", code}}).Increment();
}

void ServerCounters::CountFailure(const std::string& reason) {
  failures.Add({{"reason", reason}}).Increment();
}

}  // namespace penumbra
