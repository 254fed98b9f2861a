// The sockets that the server listens on, and the loop that accepts on them.
//
//   auto sockets = ListeningSockets::Open("127.0.0.1:0");
//   AcceptLoop loop(*std::move(sockets), table, [&](int listener, int fd) { … });
//
// The loop is our own because gRPC's stops for good when accept fails once, as it does when the
// process is out of descriptors (CVE-2023-4785; gRPC issues 16058 and 29308).
#pragma once

#include <functional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "server/security/connection_table.h"

namespace penumbra {

class ListeningSockets {
 public:
  // `address` as CheckListenAddress accepts it. "[::]" takes IPv4 too. A socket file without a
  // server behind it is replaced.
  //
  // Errors  kUnavailable CANNOT_LISTEN, with the system's words
  static absl::StatusOr<ListeningSockets> Open(const std::string& address);

  ListeningSockets(ListeningSockets&& other) noexcept;
  ListeningSockets& operator=(ListeningSockets&&) = delete;
  ~ListeningSockets();  // removes the socket file

  // With the port that was taken.
  const std::string& address() const { return address_; }
  const std::vector<int>& descriptors() const { return descriptors_; }

 private:
  explicit ListeningSockets(std::string address) : address_(std::move(address)) {}
  absl::Status OpenFile(const std::string& path);
  absl::Status OpenTcp();

  std::string address_;
  std::vector<int> descriptors_;
  std::string file_;  // empty: none
};

class AcceptLoop {
 public:
  // Owns the connection that it is given.
  using HandOver = std::function<void(int listener, int fd)>;

  AcceptLoop(ListeningSockets sockets, ConnectionTable& connections, HandOver hand_over);
  ~AcceptLoop();  // no longer accepts; what is accepted stays open

 private:
  void Run();
  // False: there is nothing to accept, or no means to.
  bool AcceptOne(int listener);

  const ListeningSockets sockets_;
  ConnectionTable& connections_;
  const HandOver hand_over_;
  int stop_ = -1;  // readable once the loop has to end
  std::thread thread_;
};

}  // namespace penumbra
