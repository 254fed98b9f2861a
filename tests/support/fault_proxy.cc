#include "tests/support/fault_proxy.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <deque>
#include <random>
#include <string_view>
#include <utility>

namespace penumbra::testing {
namespace {

using Clock = std::chrono::steady_clock;

// How often a thread looks whether it is to stop, or the faults are others.
constexpr std::chrono::milliseconds kLook{10};
// On its way at most, each way: then the sender feels it.
constexpr size_t kMaxQueuedBytes = size_t{1} << 20;
constexpr size_t kReadBytes = 16384;
// What a packet carries, and how long TCP waits at least before it sends one again.
constexpr size_t kPacketBytes = 1448;
constexpr std::chrono::milliseconds kSentAgainAfter{200};

sockaddr_in Loopback(const std::string& address) {
  sockaddr_in place{};
  place.sin_family = AF_INET;
  place.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  place.sin_port = htons(static_cast<uint16_t>(std::stoi(address.substr(address.rfind(':') + 1))));
  return place;
}

void Check(bool is_well) {
  if (!is_well) std::abort();
}

void Reset(int socket) {
  const linger at_once{.l_onoff = 1, .l_linger = 0};
  setsockopt(socket, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
  close(socket);
}

void SendAtOnce(int socket) {
  const int on = 1;
  setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
}

bool IsReadable(int socket, std::chrono::milliseconds patience) {
  pollfd wanted{.fd = socket, .events = POLLIN, .revents = 0};
  return poll(&wanted, 1, static_cast<int>(patience.count())) > 0;
}

// From one socket to another.
class Way {
 public:
  Way(int from, int to) : from_(from), to_(to) {}

  bool is_over() const { return has_ended_ && parcels_.empty(); }

  // Takes what has come, or waits for a moment.
  void Receive(const LinkFaults& faults) {
    const auto patience = parcels_.empty() ? kLook : kLook / 10;
    if (has_ended_ || queued_ >= kMaxQueuedBytes) return std::this_thread::sleep_for(patience);
    if (!IsReadable(from_, patience)) return;
    std::string bytes(kReadBytes, '\0');
    const ssize_t count = recv(from_, bytes.data(), bytes.size(), 0);
    has_ended_ = count <= 0;
    if (has_ended_) return;
    bytes.resize(static_cast<size_t>(count));
    queued_ += bytes.size();
    parcels_.push_back({Clock::now() + faults.latency + Resending(bytes.size(), faults.lost_share),
                        std::move(bytes)});
  }

  // Passes on what is due, and says how much that was.
  uint64_t Deliver(const LinkFaults& faults) {
    if (faults.is_black_hole) return 0;
    uint64_t delivered = 0;
    const auto now = Clock::now();
    while (!parcels_.empty() && parcels_.front().due <= now && free_at_ <= now) {
      const size_t size = SendSome(faults.slice_bytes);
      if (size == 0) break;
      delivered += size;
      if (faults.bytes_per_second == 0) continue;
      free_at_ = now + std::chrono::microseconds(size * 1'000'000 / faults.bytes_per_second);
    }
    return delivered;
  }

 private:
  // How much later what was read arrives, since one of its packets or more were lost.
  Clock::duration Resending(size_t bytes, double lost_share) {
    Clock::duration later{0};
    for (size_t packet = 0; packet * kPacketBytes < bytes; ++packet) {
      if (std::bernoulli_distribution(lost_share)(random_)) later = kSentAgainAfter;
    }
    return later;
  }

  struct Parcel {
    Clock::time_point due;
    std::string bytes;
    size_t sent = 0;
  };

  // Of the first parcel. 0: the receiver takes nothing now, or is gone.
  size_t SendSome(size_t most) {
    Parcel& parcel = parcels_.front();
    const std::string_view rest = std::string_view(parcel.bytes).substr(parcel.sent);
    const size_t wanted = most > 0 ? std::min(most, rest.size()) : rest.size();
    const ssize_t count = send(to_, rest.data(), wanted, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (count < 0) {
      if (errno == EAGAIN || errno == EINTR) return 0;
      has_ended_ = true;
      parcels_.clear();
      return 0;
    }
    const auto size = static_cast<size_t>(count);
    queued_ -= size;
    parcel.sent += size;
    if (parcel.sent == parcel.bytes.size()) parcels_.pop_front();
    return size;
  }

  const int from_, to_;
  std::deque<Parcel> parcels_;
  size_t queued_ = 0;
  std::minstd_rand random_{7};
  bool has_ended_ = false;
  Clock::time_point free_at_{};  // when the line takes more
};

}  // namespace

struct FaultProxy::Link {
  int client = -1;
  int server = -1;
  std::atomic<bool> is_reset = false;
  std::atomic<int> ways = 2;  // that are carried still
  std::jthread there, back;

  ~Link() {
    Stop();
    for (const int socket : {client, server}) {
      if (socket >= 0) is_reset ? Reset(socket) : void(close(socket));
    }
  }
  void Stop() {
    there = {};
    back = {};
  }
};

FaultProxy::FaultProxy(const std::string& target) : target_(target) {
  listener_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in place = Loopback(":0");
  socklen_t size = sizeof place;
  Check(bind(listener_, reinterpret_cast<sockaddr*>(&place), size) == 0);
  Check(listen(listener_, 128) == 0);
  Check(getsockname(listener_, reinterpret_cast<sockaddr*>(&place), &size) == 0);
  address_ = "127.0.0.1:" + std::to_string(ntohs(place.sin_port));
  acceptor_ = std::jthread([this](const std::stop_token& stop) { Accept(stop); });
}

FaultProxy::~FaultProxy() {
  acceptor_ = {};
  links_.clear();
  ForgetOrphans();
  close(listener_);
}

void FaultProxy::Set(const LinkFaults& faults) {
  std::lock_guard lock(mutex_);
  faults_ = faults;
}

LinkFaults FaultProxy::faults() const {
  std::lock_guard lock(mutex_);
  return faults_;
}

void FaultProxy::ResetAll() {
  for (const auto& link : TakeLinks()) link->is_reset = true;
}

void FaultProxy::Orphan() {
  std::vector<int> servers;
  for (const auto& link : TakeLinks()) {
    link->Stop();
    link->is_reset = true;
    servers.push_back(std::exchange(link->server, -1));
  }
  std::lock_guard lock(mutex_);
  orphans_.insert(orphans_.end(), servers.begin(), servers.end());
}

void FaultProxy::ForgetOrphans() {
  std::lock_guard lock(mutex_);
  for (const int socket : std::exchange(orphans_, {})) Reset(socket);
}

// They end without the lock, which their threads take.
std::list<std::unique_ptr<FaultProxy::Link>> FaultProxy::TakeLinks() {
  std::lock_guard lock(mutex_);
  return std::exchange(links_, {});
}

void FaultProxy::Accept(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    if (!IsReadable(listener_, kLook)) continue;
    const int client = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    if (client < 0) continue;
    ++accepted_;
    const int server = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const sockaddr_in place = Loopback(target_);
    if (refuses_ || connect(server, reinterpret_cast<const sockaddr*>(&place), sizeof place) != 0) {
      Reset(client);
      close(server);
      continue;
    }
    SendAtOnce(client);
    SendAtOnce(server);
    auto link = std::make_unique<Link>();
    Link& carried = *link;
    link->client = client;
    link->server = server;
    std::lock_guard lock(mutex_);
    std::erase_if(links_, [](const auto& other) { return other->ways == 0; });
    links_.push_back(std::move(link));
    carried.there = std::jthread([this, &carried](const std::stop_token& token) {
      Carry(token, carried, carried.client, carried.server);
    });
    carried.back = std::jthread([this, &carried](const std::stop_token& token) {
      Carry(token, carried, carried.server, carried.client);
    });
  }
}

void FaultProxy::Carry(const std::stop_token& stop, Link& link, int from, int to) {
  Way way(from, to);
  while (!stop.stop_requested() && !way.is_over()) {
    const LinkFaults now = faults();
    way.Receive(now);
    carried_bytes_ += way.Deliver(now);
  }
  // Who is only stopped says nothing.
  if (!stop.stop_requested()) shutdown(to, SHUT_WR);
  --link.ways;
}

}  // namespace penumbra::testing
