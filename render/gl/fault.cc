#include "render/gl/fault.h"

#include "absl/strings/cord.h"

namespace penumbra::gl {
namespace {

constexpr char kPayload[] = "penumbra/gl_fault";

absl::StatusCode CodeOf(Fault fault) {
  switch (fault) {
    case Fault::kNone:
      return absl::StatusCode::kOk;
    case Fault::kOverBudget:
    case Fault::kOutOfMemory:
      return absl::StatusCode::kResourceExhausted;
    case Fault::kError:
      return absl::StatusCode::kInternal;
    case Fault::kLost:
      return absl::StatusCode::kUnavailable;
  }
  return absl::StatusCode::kInternal;
}

}  // namespace

std::string_view ReasonOf(Fault fault) {
  switch (fault) {
    case Fault::kNone:
      return "";
    case Fault::kOverBudget:
      return "QUOTA_GPU_BYTES";
    case Fault::kOutOfMemory:
      return "GL_OUT_OF_MEMORY";
    case Fault::kError:
      return "GL_ERROR";
    case Fault::kLost:
      return "GL_CONTEXT_LOST";
  }
  return "";
}

absl::Status FaultError(Fault fault, std::string_view message) {
  absl::Status status(CodeOf(fault), absl::string_view(message.data(), message.size()));
  const char byte = static_cast<char>(fault);
  if (!status.ok()) status.SetPayload(kPayload, absl::Cord(absl::string_view(&byte, 1)));
  return status;
}

Fault FaultOf(const absl::Status& status) {
  const auto payload = status.GetPayload(kPayload);
  if (!payload || payload->size() != 1) return Fault::kNone;
  return static_cast<Fault>(std::string(*payload)[0]);
}

}  // namespace penumbra::gl
