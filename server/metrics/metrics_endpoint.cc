#include "server/metrics/metrics_endpoint.h"

#include <prometheus/collectable.h>
#include <prometheus/exposer.h>

#include <exception>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "render/scene/field_error.h"
#include "server/listen_address.h"

namespace penumbra {
namespace {

constexpr char kField[] = "metrics_listen";

// A scraper that sends nothing, or reads nothing, is let go after this.
constexpr char kRequestTimeoutMs[] = "5000";

// Debian's civetweb is built without IPv6.
absl::Status CheckAddress(const std::string& address) {
  const bool may_serve = !address.starts_with("unix:") && !address.starts_with("[");
  if (may_serve && CheckListenAddress(address).ok()) return absl::OkStatus();
  return FieldError(absl::StatusCode::kInvalidArgument, "BAD_ADDRESS", kField,
                    absl::StrCat("found '", address,
                                 "', need a loopback address and port such as 127.0.0.1:9464"));
}

absl::Status CannotServe(const std::string& address, const std::string& why) {
  return FieldError(absl::StatusCode::kUnavailable, "CANNOT_LISTEN", kField,
                    absl::StrCat("found ", address, ": ", why, ", need an address to listen on"));
}

// civetweb knows no names.
std::string Numeric(const std::string& address) {
  constexpr std::string_view kName = "localhost:";
  if (!address.starts_with(kName)) return address;
  return absl::StrCat("127.0.0.1:", address.substr(kName.size()));
}

}  // namespace

absl::StatusOr<std::unique_ptr<MetricsEndpoint>> MetricsEndpoint::Open(
    const std::string& address, std::shared_ptr<prometheus::Collectable> metrics) {
  if (auto status = CheckAddress(address); !status.ok()) return status;
  const std::string numeric = Numeric(address);
  if (auto status = TryListening(numeric); !status.ok()) {
    return CannotServe(address, "in use or not this machine's");
  }
  std::unique_ptr<MetricsEndpoint> endpoint(new MetricsEndpoint());
  endpoint->metrics_ = std::move(metrics);
  try {
    endpoint->exposer_ = std::make_unique<prometheus::Exposer>(std::vector<std::string>{
        "listening_ports", numeric, "num_threads", "2", "request_timeout_ms", kRequestTimeoutMs});
    endpoint->exposer_->RegisterCollectable(endpoint->metrics_);
  } catch (const std::exception& error) {
    return CannotServe(address, error.what());
  }
  const auto ports = endpoint->exposer_->GetListeningPorts();
  if (ports.empty()) return CannotServe(address, "no port");
  endpoint->address_ = absl::StrCat(numeric.substr(0, numeric.rfind(':') + 1), ports.front());
  return endpoint;
}

MetricsEndpoint::~MetricsEndpoint() = default;

}  // namespace penumbra
