#include "server/listen_address.h"

#include <arpa/inet.h>
#include <netdb.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <string_view>

#include "render/scene/field_error.h"

namespace penumbra {
namespace {

constexpr std::string_view kUnixPrefix = "unix:";

bool IsPort(const std::string& text) {
  unsigned port = 0;
  const char* end = text.data() + text.size();
  const auto parsed = std::from_chars(text.data(), end, port);
  return parsed.ec == std::errc() && parsed.ptr == end && port <= 65'535;
}

// By the bytes: a name such as 127.example.org can stand for any address.
bool IsLoopback(const std::string& host) {
  if (host == "localhost" || host == "::1") return true;
  uint8_t octets[4];
  return ::inet_pton(AF_INET, host.c_str(), octets) == 1 && octets[0] == 127;
}

struct Descriptor {
  int fd;
  ~Descriptor() {
    if (fd >= 0) ::close(fd);
  }
};

// gRPC removes a socket file that is there, so one with a server behind it has to be found here.
absl::Status TryUnix(const std::string& address) {
  const std::string path = address.substr(kUnixPrefix.size());
  sockaddr_un name{};
  name.sun_family = AF_UNIX;
  if (path.size() >= sizeof(name.sun_path)) return CannotListen(address, "path too long");
  std::memcpy(name.sun_path, path.data(), path.size());
  const Descriptor probe{::socket(AF_UNIX, SOCK_STREAM, 0)};
  if (::connect(probe.fd, reinterpret_cast<const sockaddr*>(&name), sizeof(name)) == 0) {
    return CannotListen(address, std::strerror(EADDRINUSE));
  }
  const std::string folder = path.substr(0, path.rfind('/') + 1);
  if (::access(folder.empty() ? "." : folder.c_str(), W_OK) != 0) {
    return CannotListen(address, std::strerror(errno));
  }
  return absl::OkStatus();
}

absl::Status TryTcp(const std::string& address, const HostAndPort& parts) {
  addrinfo hints{};
  hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (const int error = ::getaddrinfo(parts.host.c_str(), parts.port.c_str(), &hints, &found);
      error != 0) {
    return CannotListen(address, ::gai_strerror(error));
  }
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> owner(found, &::freeaddrinfo);
  const Descriptor probe{::socket(found->ai_family, SOCK_STREAM, 0)};
  const int on = 1;
  ::setsockopt(probe.fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on));
  if (::bind(probe.fd, found->ai_addr, found->ai_addrlen) != 0 || ::listen(probe.fd, 1) != 0) {
    return CannotListen(address, std::strerror(errno));
  }
  return absl::OkStatus();
}

}  // namespace

std::optional<HostAndPort> SplitAddress(const std::string& address) {
  const size_t colon = address.rfind(':');
  if (colon == std::string::npos) return std::nullopt;
  std::string host = address.substr(0, colon);
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
  } else if (host.find(':') != std::string::npos) {
    return std::nullopt;
  }
  return HostAndPort{host, address.substr(colon + 1)};
}

std::optional<std::string> SocketPath(const std::string& address) {
  if (!address.starts_with(kUnixPrefix)) return std::nullopt;
  return address.substr(kUnixPrefix.size());
}

bool IsLocalAddress(const std::string& address) {
  if (SocketPath(address)) return true;
  const auto parts = SplitAddress(address);
  return parts && IsLoopback(parts->host);
}

absl::Status CheckListenAddress(const std::string& address, bool has_tls) {
  const auto path = SocketPath(address);
  if (path && !path->empty()) return absl::OkStatus();
  const auto parts = SplitAddress(address);
  const bool is_address = !path && parts && IsPort(parts->port) && !parts->host.empty();
  if (is_address && (has_tls || IsLoopback(parts->host))) return absl::OkStatus();
  if (is_address) {
    return FieldError(absl::StatusCode::kInvalidArgument, "NEEDS_TLS", "listen",
                      "found '" + address +
                          "' without TLS, need --tls-certificate and --tls-key to be reached from "
                          "other machines, or a loopback address such as 127.0.0.1:7717");
  }
  return FieldError(
      absl::StatusCode::kInvalidArgument, "BAD_ADDRESS", "listen",
      "found '" + address + "', need an address and port such as 127.0.0.1:7717, or unix:PATH");
}

absl::Status CannotListen(const std::string& address, const char* reason) {
  return FieldError(absl::StatusCode::kUnavailable, "CANNOT_LISTEN", "listen",
                    "found " + address + ": " + reason + ", need an address to listen on");
}

absl::Status TryListening(const std::string& address) {
  if (SocketPath(address)) return TryUnix(address);
  const auto parts = SplitAddress(address);
  return parts ? TryTcp(address, *parts) : CannotListen(address, "no address");
}

}  // namespace penumbra
