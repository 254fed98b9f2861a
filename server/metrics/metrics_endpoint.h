// Serves metrics to Prometheus over HTTP, at /metrics of an address of its own.
//
//   auto endpoint = MetricsEndpoint::Open("127.0.0.1:9464", collector);
//
// On loopback only, since it asks nobody who they are. Two threads of its own answer, so that slow
// scrapers take nothing from clients. Closing it takes up to 2 s: civetweb looks up from its socket
// no more often.
#pragma once

#include <memory>
#include <string>

#include "absl/status/statusor.h"

namespace prometheus {
class Collectable;
class Exposer;
}  // namespace prometheus

namespace penumbra {

class MetricsEndpoint {
 public:
  // `address`  "127.0.0.1:9464", or another of IPv4 loopback; port 0 takes a free one
  //
  // Errors  kInvalidArgument BAD_ADDRESS; kUnavailable CANNOT_LISTEN
  static absl::StatusOr<std::unique_ptr<MetricsEndpoint>> Open(
      const std::string& address, std::shared_ptr<prometheus::Collectable> metrics);
  ~MetricsEndpoint();

  // With the port that was taken.
  const std::string& address() const { return address_; }

 private:
  MetricsEndpoint() = default;

  std::string address_;
  std::shared_ptr<prometheus::Collectable> metrics_;
  std::unique_ptr<prometheus::Exposer> exposer_;
};

}  // namespace penumbra
