// What went over the wire.
#pragma once

#include <cstdint>

namespace penumbra {

// One update of a subscription, together with those before it that the callback was too slow for.
struct UpdateTraffic {
  uint64_t messages = 0;
  uint64_t bytes = 0;        // of the messages, before HTTP/2's framing
  double received_ms = 0.0;  // steady clock, when the last message was read
  // Steady clock, when this client heard of the revision, or asked for the artifact, whichever came
  // later: what lies between is computing and sending.
  double since_ms = 0.0;
  bool is_last = false;  // the subscription is over, whatever for: no update follows
};

// Since the connection was made.
struct UploadTraffic {
  uint64_t blobs_sent = 0;
  uint64_t bytes_sent = 0;
  uint64_t blobs_known = 0;  // asked for, and there already
};

}  // namespace penumbra
