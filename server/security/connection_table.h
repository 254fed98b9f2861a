// The connections that are open: how many, from where, and whether anyone on them has been let in.
//
//   if (!table.Add(fd, peer)) ::close(fd);   // in the loop that accepts
//   table.OnAdmitted(context.peer());        // by the guard, at each call that it lets in
//   table.Sweep(now);                        // once a second
//
// gRPC owns the descriptors and does not say when it closes one: a descriptor that is no longer the
// socket that it was counts as closed.
#pragma once

#include <sys/socket.h>
#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <unordered_map>

namespace penumbra {

struct ConnectionLimits {
  // At a time. 0: half of the descriptors that the process may have, so that it never runs out.
  int max_connections = 0;
  // From one address. Not of this machine's own, from which a proxy has them all.
  int max_connections_per_address = 256;
  // A connection on which nobody has been let into a call for so long is cut: those that send half
  // a request and stay are never idle to gRPC. Health checks alone do not count.
  std::chrono::milliseconds stranger_timeout{60'000};
};

// Where a connection comes from.
struct PeerAddress {
  std::string host;  // to count by; empty: this machine
  std::string name;  // as ServerContext::peer() has it; empty: without one, a socket file's

  static PeerAddress Of(const sockaddr_storage& address);
};

class ConnectionTable {
 public:
  explicit ConnectionTable(const ConnectionLimits& limits);

  // Counts it, if there may be another one from there.
  bool Add(int fd, const PeerAddress& peer);
  void OnAdmitted(const std::string& peer_name);
  // Forgets what is closed and cuts strangers.
  void Sweep(std::chrono::steady_clock::time_point now);

  size_t size() const;
  int max_connections() const { return limits_.max_connections; }

 private:
  struct Connection {
    int fd = -1;
    ino_t inode = 0;
    std::string host;
    std::chrono::steady_clock::time_point since;
    bool is_admitted = false;
  };
  using Connections = std::unordered_map<std::string, Connection>;

  bool HasRoom(const std::string& host) const;
  Connections::iterator Forget(Connections::iterator connection);
  void ForgetClosed();

  ConnectionLimits limits_;
  mutable std::mutex mutex_;
  Connections connections_;  // by the peer's name
  std::map<std::string, int> count_by_host_;
  uint64_t unnamed_ = 0;  // so far
  std::chrono::steady_clock::time_point looked_;
};

}  // namespace penumbra
