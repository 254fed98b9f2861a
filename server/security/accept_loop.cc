#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <utility>

#include "server/security/listening_sockets.h"

namespace penumbra {
namespace {

// Out of descriptors or memory: how long until the next try. Whoever waits is in the backlog.
constexpr int kPauseMs = 50;
// Accepted in a row before the loop looks around.
constexpr int kAtATime = 64;

}  // namespace

AcceptLoop::AcceptLoop(ListeningSockets sockets, ConnectionTable& connections, HandOver hand_over)
    : sockets_(std::move(sockets)),
      connections_(connections),
      hand_over_(std::move(hand_over)),
      stop_(::eventfd(0, EFD_CLOEXEC)),
      thread_([this] { Run(); }) {}

AcceptLoop::~AcceptLoop() {
  const uint64_t one = 1;
  [[maybe_unused]] const auto written = ::write(stop_, &one, sizeof(one));
  thread_.join();
  ::close(stop_);
}

void AcceptLoop::Run() {
  std::vector<pollfd> polled = {{.fd = stop_, .events = POLLIN, .revents = 0}};
  for (const int fd : sockets_.descriptors()) {
    polled.push_back({.fd = fd, .events = POLLIN, .revents = 0});
  }
  for (;;) {
    ::poll(polled.data(), polled.size(), -1);
    if (polled[0].revents != 0) return;
    for (size_t i = 1; i < polled.size(); ++i) {
      if (polled[i].revents == 0) continue;
      for (int n = 0; n < kAtATime && AcceptOne(polled[i].fd); ++n) {
      }
    }
  }
}

bool AcceptLoop::AcceptOne(int listener) {
  sockaddr_storage address{};
  socklen_t size = sizeof(address);
  const int fd = ::accept4(listener, reinterpret_cast<sockaddr*>(&address), &size,
                           SOCK_NONBLOCK | SOCK_CLOEXEC);
  if (fd >= 0) {
    if (connections_.Add(fd, PeerAddress::Of(address))) {
      hand_over_(listener, fd);
    } else {
      ::close(fd);
    }
    return true;
  }
  // A connection that has gone away in the meantime is no reason to stop.
  if (errno == ECONNABORTED || errno == EINTR || errno == EPROTO) return true;
  if (errno != EAGAIN) {
    pollfd stop = {.fd = stop_, .events = POLLIN, .revents = 0};
    ::poll(&stop, 1, kPauseMs);
  }
  return false;
}

}  // namespace penumbra
