// How a RemoteEngine reaches its server, and whom it tells of that.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "absl/status/status.h"
#include "client/session/client_credentials.h"

namespace penumbra {

// What becomes of a scene's connection.
struct ConnectionEvent {
  enum class Kind { kLost, kRestored, kGivenUp };
  Kind kind = Kind::kLost;
  std::string scene_id;
  absl::Status reason;          // why it was lost, or given up
  int attempts = 0;             // to connect, so far
  bool missed_nothing = false;  // restored: what has changed meanwhile was told in small
};

struct RemoteEngineOptions {
  std::string address;                   // "host:port"
  std::string client_name = "penumbra";  // for the server's log
  double connect_timeout_s = 5.0;
  // For the answer to anything but an artifact. A large upload has as long for each 16 MiB.
  double call_timeout_s = 30.0;
  // A server that is silent for so long is asked whether it is there, and has as long again to
  // answer: then the connection counts as lost. Servers let go who asks every 5 s or more often.
  double keepalive_s = 12.0;
  // How long a session that has lost its connection tries to get another one; 0: not at all.
  double reconnect_for_s = 30.0;
  // Told of that, on a thread of the session's; may be null.
  std::function<void(const ConnectionEvent&)> on_connection = nullptr;
  // Told on a thread of a session's that the computing of who calls is used up, with the server's
  // words for it: what is new then waits for others. OK: there is some again. May be null.
  std::function<void(const absl::Status& quota)> on_compute_quota = nullptr;
  // Told while meshes are being uploaded, on the thread that commits; may be null.
  std::function<void(uint64_t sent_bytes, uint64_t total_bytes)> upload_progress = nullptr;
  ClientCredentials credentials{};
};

}  // namespace penumbra
