#include "proto/convert/status_convert.h"

#include <string>
#include <string_view>

#include "google/rpc/error_details.pb.h"
#include "render/scene/field_error.h"

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

absl::StatusCode CodeOf(int code) {
  if (code < 0 || code > kHighestCode) return absl::StatusCode::kUnknown;
  return static_cast<absl::StatusCode>(code);
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
  return proto;
}

absl::Status FromProto(const google::rpc::Status& status) {
  const absl::StatusCode code = CodeOf(status.code());
  if (code == absl::StatusCode::kOk) return absl::OkStatus();
  for (const auto& detail : status.details()) {
    google::rpc::ErrorInfo info;
    if (!detail.Is<google::rpc::ErrorInfo>() || !detail.UnpackTo(&info)) continue;
    if (info.domain() != kErrorDomain) continue;
    const auto field = info.metadata().find(kFieldKey);
    const std::string path = field == info.metadata().end() ? std::string() : field->second;
    return FieldError(code, info.reason(), path, WithoutPath(status.message(), path));
  }
  return absl::Status(code, status.message());
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
  return absl::Status(CodeOf(static_cast<int>(status.error_code())), status.error_message());
}

}  // namespace penumbra
