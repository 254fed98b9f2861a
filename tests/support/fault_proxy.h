// A TCP connection that is as bad as real ones get, between a client and a server of the same test.
//
//   FaultProxy link(server.address());
//   auto engine = RemoteEngine::Connect({.address = link.address()});
//   link.Set({.latency = 200ms, .bytes_per_second = 125'000});
//   link.ResetAll();
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace penumbra::testing {

// Each way on its own.
struct LinkFaults {
  std::chrono::milliseconds latency{0};
  uint64_t bytes_per_second = 0;  // 0: as many as there are
  size_t slice_bytes = 0;         // what is written at once; 0: as it comes
  // Of the packets those that get lost, in [0, 1]: TCP sends them again, and until then what comes
  // after them waits.
  double lost_share = 0;
  bool is_black_hole = false;  // nothing arrives, and nobody is told
};

class FaultProxy {
 public:
  // Of "127.0.0.1:PORT". Aborts where there is no socket to be had.
  explicit FaultProxy(const std::string& target);
  ~FaultProxy();
  FaultProxy(const FaultProxy&) = delete;
  FaultProxy& operator=(const FaultProxy&) = delete;

  const std::string& address() const { return address_; }

  // From now on, also of the connections that there are.
  void Set(const LinkFaults& faults);
  // Both ends of every connection are reset, whatever is on its way.
  void ResetAll();
  // The clients' ends are reset, and the server's stay open and silent until ForgetOrphans: to it
  // nothing has happened.
  void Orphan();
  void ForgetOrphans();
  // New connections are reset as soon as they are there, or not any more.
  void Refuse(bool does) { refuses_ = does; }

  uint64_t carried_bytes() const { return carried_bytes_; }
  size_t accepted() const { return accepted_; }

 private:
  struct Link;

  void Accept(const std::stop_token& stop);
  void Carry(const std::stop_token& stop, Link& link, int from, int to);
  LinkFaults faults() const;
  std::list<std::unique_ptr<Link>> TakeLinks();

  const std::string target_;
  std::string address_;
  int listener_ = -1;
  std::atomic<bool> refuses_ = false;
  std::atomic<uint64_t> carried_bytes_ = 0;
  std::atomic<size_t> accepted_ = 0;
  mutable std::mutex mutex_;  // guards the rest
  LinkFaults faults_;
  std::list<std::unique_ptr<Link>> links_;
  std::vector<int> orphans_;
  std::jthread acceptor_;  // ends first
};

}  // namespace penumbra::testing
