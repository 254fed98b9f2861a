#include "server/security/connection_table.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>

#include "absl/strings/str_cat.h"

namespace penumbra {
namespace {

// Looking for closed ones takes 300 ns each. Whoever keeps the table full and knocks does not make
// it look more often than this.
constexpr std::chrono::milliseconds kLookInterval{50};

int HalfOfTheDescriptors() {
  rlimit limit{};
  ::getrlimit(RLIMIT_NOFILE, &limit);
  constexpr rlim_t kMost = 1 << 20;
  return static_cast<int>(std::min(limit.rlim_cur, kMost) / 2);
}

// 0 where `fd` is no socket.
ino_t InodeOf(int fd) {
  struct stat found {};
  return ::fstat(fd, &found) == 0 && S_ISSOCK(found.st_mode) ? found.st_ino : 0;
}

// Through a descriptor of our own: gRPC may close the other one, and somebody get its number, at
// any time.
void Cut(int fd, ino_t inode) {
  const int own = ::dup(fd);
  if (own < 0) return;
  if (InodeOf(own) == inode) ::shutdown(own, SHUT_RDWR);
  ::close(own);
}

std::string TextOf(int family, const void* address) {
  char text[INET6_ADDRSTRLEN] = {};
  ::inet_ntop(family, address, text, sizeof(text));
  return text;
}

PeerAddress FourBytes(const uint8_t* octets, in_port_t port) {
  const std::string host = TextOf(AF_INET, octets);
  return {.host = octets[0] == 127 ? std::string() : host,
          .name = absl::StrCat("ipv4:", host, ":", ntohs(port))};
}

}  // namespace

PeerAddress PeerAddress::Of(const sockaddr_storage& address) {
  if (address.ss_family == AF_INET) {
    const auto& in = reinterpret_cast<const sockaddr_in&>(address);
    return FourBytes(reinterpret_cast<const uint8_t*>(&in.sin_addr), in.sin_port);
  }
  if (address.ss_family != AF_INET6) return {};
  const auto& in = reinterpret_cast<const sockaddr_in6&>(address);
  const uint8_t* octets = in.sin6_addr.s6_addr;
  if (IN6_IS_ADDR_V4MAPPED(&in.sin6_addr)) return FourBytes(octets + 12, in.sin6_port);
  const std::string host = TextOf(AF_INET6, octets);
  // A single customer has 2^64 addresses: they count as one.
  in6_addr network = in.sin6_addr;
  std::fill(network.s6_addr + 8, network.s6_addr + 16, uint8_t{0});
  return {.host = IN6_IS_ADDR_LOOPBACK(&in.sin6_addr) ? std::string() : TextOf(AF_INET6, &network),
          .name = absl::StrCat("ipv6:%5B", host, "%5D:", ntohs(in.sin6_port))};
}

ConnectionTable::ConnectionTable(const ConnectionLimits& limits) : limits_(limits) {
  const int half = HalfOfTheDescriptors();
  if (limits_.max_connections == 0) limits_.max_connections = half;
  limits_.max_connections = std::min(limits_.max_connections, half);
}

bool ConnectionTable::HasRoom(const std::string& host) const {
  if (connections_.size() >= static_cast<size_t>(limits_.max_connections)) return false;
  const auto count = count_by_host_.find(host);
  return host.empty() || count == count_by_host_.end() ||
         count->second < limits_.max_connections_per_address;
}

bool ConnectionTable::Add(int fd, const PeerAddress& peer) {
  const auto now = std::chrono::steady_clock::now();
  std::lock_guard lock(mutex_);
  if (!HasRoom(peer.host) && now - looked_ >= kLookInterval) {
    ForgetClosed();
    looked_ = now;
  }
  if (!HasRoom(peer.host)) return false;
  const std::string name = peer.name.empty() ? absl::StrCat("#", ++unnamed_) : peer.name;
  // The same port again: the connection that had it is closed.
  if (const auto old = connections_.find(name); old != connections_.end()) Forget(old);
  connections_[name] = {.fd = fd,
                        .inode = InodeOf(fd),
                        .host = peer.host,
                        .since = now,
                        .is_admitted = peer.name.empty()};
  ++count_by_host_[peer.host];
  return true;
}

void ConnectionTable::OnAdmitted(const std::string& peer_name) {
  std::lock_guard lock(mutex_);
  const auto found = connections_.find(peer_name);
  if (found != connections_.end()) found->second.is_admitted = true;
}

ConnectionTable::Connections::iterator ConnectionTable::Forget(Connections::iterator connection) {
  const auto count = count_by_host_.find(connection->second.host);
  if (--count->second == 0) count_by_host_.erase(count);
  return connections_.erase(connection);
}

void ConnectionTable::ForgetClosed() {
  for (auto it = connections_.begin(); it != connections_.end();) {
    it = InodeOf(it->second.fd) == it->second.inode ? std::next(it) : Forget(it);
  }
}

void ConnectionTable::Sweep(std::chrono::steady_clock::time_point now) {
  std::lock_guard lock(mutex_);
  ForgetClosed();
  for (const auto& [name, connection] : connections_) {
    const bool is_late = now - connection.since >= limits_.stranger_timeout;
    if (is_late && !connection.is_admitted) Cut(connection.fd, connection.inode);
  }
}

size_t ConnectionTable::size() const {
  std::lock_guard lock(mutex_);
  return connections_.size();
}

}  // namespace penumbra
