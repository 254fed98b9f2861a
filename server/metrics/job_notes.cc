#include "server/metrics/job_notes.h"

#include <string>

#include "server/log/refusal.h"

namespace penumbra {
namespace {

constexpr double kSecondsPerMs = 1e-3;

bool IsOfClients(const absl::Status& status) {
  return absl::IsNotFound(status) || absl::IsInvalidArgument(status) ||
         absl::IsFailedPrecondition(status);
}

void NoteFailure(ServerCounters& counters, Logger& logger, const JobReport& job) {
  const std::string reason = FailureReason(job.status);
  const std::string error(job.status.message());
  counters.CountFailure(reason);
  const LogField fields[] = {{"technique", job.technique},
                             {"code", absl::StatusCodeToString(job.status.code())},
                             {"reason", reason},
                             {"computed_ms", job.computed_ms},
                             {"error", error}};
  const LogLevel level = IsOfClients(job.status) ? LogLevel::kDebug : LogLevel::kWarning;
  logger.Write(level, "job_failed", fields);
}

}  // namespace

JobObserver NoteJobs(ServerCounters& counters, Logger& logger) {
  return [&counters, &logger](const JobReport& job) {
    counters.queue_seconds.Observe(job.waited_ms * kSecondsPerMs);
    if (!job.was_known) counters.ObserveCompute(job.technique, job.computed_ms * kSecondsPerMs);
    if (job.first_artifact_ms) {
      counters.first_artifact_seconds.Observe(*job.first_artifact_ms * kSecondsPerMs);
    }
    if (job.final_artifact_ms) {
      counters.final_artifact_seconds.Observe(*job.final_artifact_ms * kSecondsPerMs);
    }
    if (job.outcome == JobReport::Outcome::kFailed) NoteFailure(counters, logger, job);
  };
}

}  // namespace penumbra
