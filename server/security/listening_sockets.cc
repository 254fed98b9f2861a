#include "server/security/listening_sockets.h"

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>

#include "server/listen_address.h"

namespace penumbra {
namespace {

using Addresses = std::unique_ptr<addrinfo, void (*)(addrinfo*)>;

int PortOf(int fd) {
  sockaddr_storage name{};
  socklen_t size = sizeof(name);
  ::getsockname(fd, reinterpret_cast<sockaddr*>(&name), &size);
  const bool is_v6 = name.ss_family == AF_INET6;
  return ntohs(is_v6 ? reinterpret_cast<sockaddr_in6&>(name).sin6_port
                     : reinterpret_cast<sockaddr_in&>(name).sin_port);
}

void SetPort(sockaddr* address, int port) {
  auto& field = address->sa_family == AF_INET6 ? reinterpret_cast<sockaddr_in6*>(address)->sin6_port
                                               : reinterpret_cast<sockaddr_in*>(address)->sin_port;
  field = htons(static_cast<uint16_t>(port));
}

// A listening socket; negative, with errno, where there can be none.
int ListenTcp(const addrinfo& found) {
  const int fd = ::socket(found.ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (fd < 0) return fd;
  const int on = 1, off = 0;
  ::setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on));
  // Connections have it from here: small messages are not held back.
  ::setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));
  if (found.ai_family == AF_INET6) {
    ::setsockopt(fd, IPPROTO_IPV6, IPV6_V6ONLY, &off, sizeof(off));
  }
  if (::bind(fd, found.ai_addr, found.ai_addrlen) == 0 && ::listen(fd, SOMAXCONN) == 0) return fd;
  const int error = errno;
  ::close(fd);
  errno = error;
  return -1;
}

}  // namespace

absl::StatusOr<ListeningSockets> ListeningSockets::Open(const std::string& address) {
  ListeningSockets sockets(address);
  const auto path = SocketPath(address);
  const absl::Status status = path ? sockets.OpenFile(*path) : sockets.OpenTcp();
  if (!status.ok()) return status;
  return sockets;
}

ListeningSockets::ListeningSockets(ListeningSockets&& other) noexcept
    : address_(std::move(other.address_)),
      descriptors_(std::exchange(other.descriptors_, {})),
      file_(std::exchange(other.file_, {})) {}

ListeningSockets::~ListeningSockets() {
  for (const int fd : descriptors_) ::close(fd);
  if (!file_.empty()) ::unlink(file_.c_str());
}

absl::Status ListeningSockets::OpenFile(const std::string& path) {
  if (auto status = TryListening(address_); !status.ok()) return status;
  struct stat found {};
  // What no server listens on is the file of one that ended without removing it.
  if (::lstat(path.c_str(), &found) == 0 && S_ISSOCK(found.st_mode)) ::unlink(path.c_str());
  sockaddr_un name{};
  name.sun_family = AF_UNIX;
  std::memcpy(name.sun_path, path.data(), path.size());
  const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (fd >= 0) descriptors_.push_back(fd);
  if (fd < 0 || ::bind(fd, reinterpret_cast<const sockaddr*>(&name), sizeof(name)) != 0) {
    return CannotListen(address_, std::strerror(errno));
  }
  file_ = path;
  if (::listen(fd, SOMAXCONN) != 0) return CannotListen(address_, std::strerror(errno));
  return absl::OkStatus();
}

absl::Status ListeningSockets::OpenTcp() {
  const auto parts = SplitAddress(address_);
  if (!parts) return CannotListen(address_, "no address");
  addrinfo hints{};
  hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* list = nullptr;
  if (const int error = ::getaddrinfo(parts->host.c_str(), parts->port.c_str(), &hints, &list);
      error != 0) {
    return CannotListen(address_, ::gai_strerror(error));
  }
  const Addresses owner(list, &::freeaddrinfo);
  int port = 0, failure = 0;
  for (const addrinfo* found = list; found; found = found->ai_next) {
    if (port != 0) SetPort(found->ai_addr, port);
    const int fd = ListenTcp(*found);
    if (fd >= 0) {
      descriptors_.push_back(fd);
      port = PortOf(fd);
    } else {
      failure = errno;
      // "localhost" may name an IPv6 that this machine is without.
      if (failure != EADDRNOTAVAIL && failure != EAFNOSUPPORT) break;
    }
  }
  const bool has_failed = failure != 0 && failure != EADDRNOTAVAIL && failure != EAFNOSUPPORT;
  if (descriptors_.empty() || has_failed) return CannotListen(address_, std::strerror(failure));
  address_ = address_.substr(0, address_.rfind(':') + 1) + std::to_string(port);
  return absl::OkStatus();
}

}  // namespace penumbra
