#include "render/scene/retry_delay.h"

#include <string>

#include "absl/strings/cord.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"

namespace penumbra {
namespace {

constexpr char kRetryPayload[] = "penumbra/retry_ms";

}  // namespace

absl::Status WithRetryDelay(absl::Status status, double delay_ms) {
  status.SetPayload(kRetryPayload, absl::Cord(absl::StrCat(delay_ms)));
  return status;
}

std::optional<double> RetryDelayMs(const absl::Status& status) {
  const auto payload = status.GetPayload(kRetryPayload);
  double delay_ms = 0;
  if (!payload || !absl::SimpleAtod(std::string(*payload), &delay_ms)) return std::nullopt;
  return delay_ms;
}

}  // namespace penumbra
