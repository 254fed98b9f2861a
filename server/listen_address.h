// Where the server listens: on loopback or on a socket file, for it knows no authentication.
#pragma once

#include <string>

#include "absl/status/status.h"

namespace penumbra {

// Accepts "127.0.0.1:7717" (any 127.*), "[::1]:7717", "localhost:7717" and "unix:/path"; port 0
// takes a free one.
//
// Errors  kInvalidArgument BAD_ADDRESS
absl::Status CheckListenAddress(const std::string& address);

// Why `address` cannot be listened on, found by trying; OK if it can.
//
// Errors  kUnavailable CANNOT_LISTEN, with the system's words
absl::Status TryListening(const std::string& address);

}  // namespace penumbra
