#include "client/session/call_status.h"

#include "absl/strings/str_cat.h"
#include "proto/convert/status_convert.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

absl::Status GoneAway(const std::string& address, const std::string& why) {
  return absl::UnavailableError(absl::StrCat(address, ": the server has gone away", why));
}

}  // namespace

absl::Status StatusOfCall(const std::string& address, const grpc::Status& status) {
  const absl::Status converted = FromGrpcStatus(status);
  if (!ErrorReason(converted).empty()) return converted;
  switch (converted.code()) {
    case absl::StatusCode::kUnavailable:
    case absl::StatusCode::kUnknown:
      return absl::UnavailableError(
          absl::StrCat(address, ": no server answers: ", status.error_message()));
    case absl::StatusCode::kDeadlineExceeded:
      return absl::UnavailableError(absl::StrCat(address, ": no server answers in time"));
    case absl::StatusCode::kUnimplemented:
      return absl::UnavailableError(
          absl::StrCat(address, ": what answers is not this service: ", status.error_message()));
    default:
      return converted;
  }
}

absl::Status StatusOfEndedSession(const std::string& address, const grpc::Status& status) {
  const absl::Status converted = FromGrpcStatus(status);
  switch (converted.code()) {
    case absl::StatusCode::kOk:
      return GoneAway(address, "");
    case absl::StatusCode::kUnavailable:
    case absl::StatusCode::kUnknown:
    case absl::StatusCode::kCancelled:
      return GoneAway(address, absl::StrCat(": ", status.error_message()));
    default:
      return converted;
  }
}

}  // namespace penumbra
