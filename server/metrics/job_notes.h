// What the counters and the log are told of jobs.
#pragma once

#include "render/engine/job_report.h"
#include "server/counters.h"
#include "server/log/logger.h"

namespace penumbra {

// An observer for a LocalEngine; both outlive the engine. Failures that clients cause, a light that
// is gone for instance, are logged at the level of debugging, others as warnings.
JobObserver NoteJobs(ServerCounters& counters, Logger& logger);

}  // namespace penumbra
