#include "proto/convert/status_convert.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>

#include "google/rpc/error_details.pb.h"
#include "render/scene/field_error.h"
#include "render/scene/retry_delay.h"

namespace penumbra {
namespace {

constexpr char kFieldKey[] = "field";
constexpr int kHighestCode = static_cast<int>(absl::StatusCode::kUnauthenticated);

// "lights[2].edge_v: length is 0" without the path in front.
std::string_view WithoutPath(std::string_view message, std::string_view path) {
  const std::string prefix = std::string(path) + ": ";
  if (!path.empty() && message.starts_with(prefix)) message.remove_prefix(prefix.size());
  return message;
}

google::rpc::RetryInfo RetryInfoOf(double delay_ms) {
  constexpr int64_t kNsPerMs = 1'000'000, kMsPerS = 1'000;
  const auto whole_ms = static_cast<int64_t>(std::ceil(delay_ms));
  google::rpc::RetryInfo info;
  info.mutable_retry_delay()->set_seconds(whole_ms / kMsPerS);
  info.mutable_retry_delay()->set_nanos(static_cast<int32_t>(whole_ms % kMsPerS * kNsPerMs));
  return info;
}

// Negative ones, which a server should not send, count as none, and longer ones than an hour as an
// hour: whoever waits adds to it, and a clock holds no more than some centuries.
double DelayMsOf(const google::rpc::RetryInfo& info) {
  constexpr double kLongestMs = 3.6e6;
  const auto& delay = info.retry_delay();
  return std::clamp(1e3 * static_cast<double>(delay.seconds()) + 1e-6 * delay.nanos(), 0.0,
                    kLongestMs);
}

absl::StatusCode CodeOf(int code) {
  if (code < 0 || code > kHighestCode) return absl::StatusCode::kUnknown;
  return static_cast<absl::StatusCode>(code);
}

// "[REASON] text", and no other text in brackets.
absl::Status WithReasonOfMessage(absl::StatusCode code, std::string_view message) {
  constexpr std::string_view kReasonLetters = "ABCDEFGHIJKLMNOPQRSTUVWXYZ_0123456789";
  const size_t end = std::min(message.find_first_not_of(kReasonLetters, 1), message.size());
  if (end < 2 || !message.starts_with('[') || !message.substr(end).starts_with("] ")) {
    return absl::Status(code, std::string(message));
  }
  return FieldError(code, message.substr(1, end - 1), "", message.substr(end + 2));
}

}  // namespace

google::rpc::Status ToProto(const absl::Status& status) {
  google::rpc::Status proto;
  proto.set_code(static_cast<int>(status.code()));
  proto.set_message(std::string(status.message()));
  const std::string reason = ErrorReason(status);
  const std::string field = ErrorFieldPath(status);
  if (!reason.empty()) {
    google::rpc::ErrorInfo info;
    info.set_reason(reason);
    info.set_domain(kErrorDomain);
    if (!field.empty()) (*info.mutable_metadata())[kFieldKey] = field;
    proto.add_details()->PackFrom(info);
  }
  if (!field.empty()) {
    google::rpc::BadRequest request;
    auto* violation = request.add_field_violations();
    violation->set_field(field);
    violation->set_description(std::string(WithoutPath(proto.message(), field)));
    proto.add_details()->PackFrom(request);
  }
  if (const auto delay_ms = RetryDelayMs(status)) {
    proto.add_details()->PackFrom(RetryInfoOf(*delay_ms));
  }
  return proto;
}

absl::Status FromProto(const google::rpc::Status& status) {
  const absl::StatusCode code = CodeOf(status.code());
  if (code == absl::StatusCode::kOk) return absl::OkStatus();
  absl::Status converted(code, status.message());
  google::rpc::ErrorInfo info;
  google::rpc::RetryInfo retry;
  for (const auto& detail : status.details()) {
    if (detail.UnpackTo(&info) && info.domain() == kErrorDomain) {
      const auto field = info.metadata().find(kFieldKey);
      const std::string path = field == info.metadata().end() ? std::string() : field->second;
      converted = FieldError(code, info.reason(), path, WithoutPath(status.message(), path));
      break;
    }
  }
  for (const auto& detail : status.details()) {
    if (detail.UnpackTo(&retry)) return WithRetryDelay(std::move(converted), DelayMsOf(retry));
  }
  return converted;
}

grpc::Status ToGrpcStatus(const absl::Status& status) {
  if (status.ok()) return grpc::Status::OK;
  return grpc::Status(static_cast<grpc::StatusCode>(status.code()), std::string(status.message()),
                      ToProto(status).SerializeAsString());
}

absl::Status FromGrpcStatus(const grpc::Status& status) {
  if (status.ok()) return absl::OkStatus();
  google::rpc::Status details;
  if (!status.error_details().empty() && details.ParseFromString(status.error_details()) &&
      details.code() == static_cast<int>(status.error_code())) {
    return FromProto(details);
  }
  return WithReasonOfMessage(CodeOf(static_cast<int>(status.error_code())), status.error_message());
}

std::string MessageWithReason(const absl::Status& status) {
  const std::string reason = ErrorReason(status), message(status.message());
  return reason.empty() ? message : "[" + reason + "] " + message;
}

}  // namespace penumbra
