#include "server/service/call_record.h"

#include <utility>

#include "server/log/refusal.h"

namespace penumbra {

CallRecord::CallRecord(ServerCounters& counters, Logger& logger, std::string method)
    : counters_(counters),
      logger_(logger),
      method_(std::move(method)),
      number_(++counters.calls_made) {
  ++counters_.open_calls;
}

CallRecord::~CallRecord() {
  End(absl::CancelledError());
  --counters_.open_calls;
}

void CallRecord::End(const absl::Status& status) {
  if (std::exchange(has_ended_, true)) return;
  const std::chrono::duration<double> duration = std::chrono::steady_clock::now() - start_;
  counters_.ObserveCall(method_, absl::StatusCodeToString(status.code()), duration.count());
  // What a session is refused, its own record tells.
  if (status.ok() || absl::IsCancelled(status) || method_ == "Session") return;
  NoteRefusal(counters_, logger_, method_, status, {{"request", number_}});
}

}  // namespace penumbra
