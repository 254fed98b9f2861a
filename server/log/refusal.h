// How a refusal is counted and logged: by its stable reason and the field at fault, never with the
// message, which quotes what the client sent.
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "server/counters.h"
#include "server/log/logger.h"

namespace penumbra {

// The reason that an error carries, such as "STALE_BASE"; the name of its code where it carries
// none, "OK" for none. One of a bounded set of words, whatever the client sent.
std::string FailureReason(const absl::Status& status);

// `what`   the call or request, in the protocol's words
// `fields` whose it was: "session" or "request"
void NoteRefusal(ServerCounters& counters, Logger& logger, std::string_view what,
                 const absl::Status& status, std::initializer_list<LogField> fields);

}  // namespace penumbra
