#include "server/log/refusal.h"

#include <vector>

#include "render/scene/field_error.h"

namespace penumbra {

std::string FailureReason(const absl::Status& status) {
  const std::string reason = ErrorReason(status);
  return reason.empty() ? absl::StatusCodeToString(status.code()) : reason;
}

void NoteRefusal(ServerCounters& counters, Logger& logger, std::string_view what,
                 const absl::Status& status, std::initializer_list<LogField> fields) {
  const std::string reason = FailureReason(status);
  const std::string field = ErrorFieldPath(status);
  const std::string code = absl::StatusCodeToString(status.code());
  counters.CountFailure(reason);
  std::vector<LogField> all(fields);
  all.insert(all.end(), {{"call", what}, {"code", code}, {"reason", reason}, {"field", field}});
  logger.Write(LogLevel::kInfo, "refused", all);
}

}  // namespace penumbra
