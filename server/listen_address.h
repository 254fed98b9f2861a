// Where the server listens: without encryption on loopback or on a socket file alone.
#pragma once

#include <optional>
#include <string>

#include "absl/status/status.h"

namespace penumbra {

struct HostAndPort {
  std::string host;  // without the brackets of IPv6
  std::string port;
};
// Nothing where `address` is no "HOST:PORT".
std::optional<HostAndPort> SplitAddress(const std::string& address);

// The file of "unix:/path"; nothing for other addresses.
std::optional<std::string> SocketPath(const std::string& address);

// Whether nobody but this machine reaches it: "127.0.0.1:7717" (any 127.*), "[::1]:7717",
// "localhost:7717" and "unix:/path". By the bytes: a name can stand for any address.
bool IsLocalAddress(const std::string& address);

// Accepts local addresses, and with TLS any "HOST:PORT"; port 0 takes a free one.
//
// Errors  kInvalidArgument BAD_ADDRESS; NEEDS_TLS: it would be good with TLS
absl::Status CheckListenAddress(const std::string& address, bool has_tls = false);

// Why `address` cannot be listened on, found by trying; OK if it can.
//
// Errors  kUnavailable CANNOT_LISTEN, with the system's words
absl::Status TryListening(const std::string& address);
absl::Status CannotListen(const std::string& address, const char* reason);

}  // namespace penumbra
