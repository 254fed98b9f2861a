#include "server/security/connection_table.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <unistd.h>

#include <chrono>
#include <thread>
#include <vector>

namespace penumbra {
namespace {

using std::chrono::seconds, std::chrono::milliseconds, std::chrono::steady_clock;

sockaddr_storage V4(const char* host, uint16_t port) {
  sockaddr_storage storage{};
  auto& in = reinterpret_cast<sockaddr_in&>(storage);
  in.sin_family = AF_INET;
  in.sin_port = htons(port);
  inet_pton(AF_INET, host, &in.sin_addr);
  return storage;
}

sockaddr_storage V6(const char* host, uint16_t port) {
  sockaddr_storage storage{};
  auto& in = reinterpret_cast<sockaddr_in6&>(storage);
  in.sin6_family = AF_INET6;
  in.sin6_port = htons(port);
  inet_pton(AF_INET6, host, &in.sin6_addr);
  return storage;
}

// Two ends; the first plays the connection, the second its client.
struct Pair {
  Pair() { socketpair(AF_UNIX, SOCK_STREAM, 0, ends); }
  ~Pair() {
    close(ends[0]);
    close(ends[1]);
  }
  bool is_cut() const {
    char c;
    return recv(ends[1], &c, 1, MSG_DONTWAIT) == 0;
  }
  int ends[2];
};

TEST(PeerAddressTest, IsNamedAsByGrpcAndCountedByNetwork) {
  const PeerAddress four = PeerAddress::Of(V4("192.0.2.7", 4711));
  EXPECT_EQ(four.host, "192.0.2.7");
  EXPECT_EQ(four.name, "ipv4:192.0.2.7:4711");
  EXPECT_EQ(PeerAddress::Of(V4("127.0.0.2", 1)).host, "");
  const PeerAddress mapped = PeerAddress::Of(V6("::ffff:192.0.2.7", 4711));
  EXPECT_EQ(mapped.host, four.host);
  EXPECT_EQ(mapped.name, four.name);
  const PeerAddress six = PeerAddress::Of(V6("2001:db8::1", 80));
  EXPECT_EQ(six.name, "ipv6:%5B2001:db8::1%5D:80");
  EXPECT_EQ(six.host, PeerAddress::Of(V6("2001:db8::ffff:1", 81)).host);
  EXPECT_NE(six.host, PeerAddress::Of(V6("2001:db8:0:1::1", 80)).host);
  EXPECT_EQ(PeerAddress::Of(V6("::1", 80)).host, "");
}

TEST(ConnectionTableTest, C22BoundsAllAndThoseOfOneAddress) {
  ConnectionTable table({.max_connections = 5, .max_connections_per_address = 2});
  std::vector<Pair> pairs(8);
  EXPECT_TRUE(table.Add(pairs[0].ends[0], PeerAddress::Of(V4("192.0.2.1", 1))));
  EXPECT_TRUE(table.Add(pairs[1].ends[0], PeerAddress::Of(V4("192.0.2.1", 2))));
  EXPECT_FALSE(table.Add(pairs[2].ends[0], PeerAddress::Of(V4("192.0.2.1", 3))));
  EXPECT_TRUE(table.Add(pairs[3].ends[0], PeerAddress::Of(V4("192.0.2.2", 1))));
  // This machine's own have no bound but that of all.
  EXPECT_TRUE(table.Add(pairs[4].ends[0], PeerAddress::Of(V4("127.0.0.1", 1))));
  EXPECT_TRUE(table.Add(pairs[5].ends[0], PeerAddress()));
  EXPECT_FALSE(table.Add(pairs[6].ends[0], PeerAddress::Of(V4("127.0.0.1", 3))));
  EXPECT_EQ(table.size(), 5u);
}

TEST(ConnectionTableTest, ADescriptorThatIsAnotherSocketIsAClosedConnection) {
  ConnectionTable table({.max_connections = 1});
  auto first = std::make_unique<Pair>();
  ASSERT_TRUE(table.Add(first->ends[0], PeerAddress::Of(V4("192.0.2.1", 1))));
  first.reset();
  const Pair second;  // with the numbers of the first
  std::this_thread::sleep_for(milliseconds(60));
  EXPECT_TRUE(table.Add(second.ends[0], PeerAddress::Of(V4("192.0.2.1", 2))));
  EXPECT_EQ(table.size(), 1u);
}

TEST(ConnectionTableTest, C22IsNeverMoreThanHalfOfTheDescriptors) {
  const ConnectionTable table({.max_connections = 1 << 20});
  EXPECT_LE(table.max_connections(), sysconf(_SC_OPEN_MAX) / 2);
}

// C05: who has sent nothing that counts is let go.
TEST(ConnectionTableTest, C05StrangersAreCutAndOthersAreNot) {
  ConnectionTable table({.stranger_timeout = seconds(10)});
  const Pair stranger, guest, on_file;
  const auto start = steady_clock::now();
  ASSERT_TRUE(table.Add(stranger.ends[0], PeerAddress::Of(V4("192.0.2.1", 1))));
  ASSERT_TRUE(table.Add(guest.ends[0], PeerAddress::Of(V4("192.0.2.1", 2))));
  ASSERT_TRUE(table.Add(on_file.ends[0], PeerAddress()));
  table.OnAdmitted("ipv4:192.0.2.1:2");
  table.OnAdmitted("ipv4:192.0.2.1:3");  // nobody's
  table.Sweep(start + seconds(9));
  EXPECT_FALSE(stranger.is_cut());
  table.Sweep(steady_clock::now() + seconds(10));
  EXPECT_TRUE(stranger.is_cut());
  EXPECT_FALSE(guest.is_cut());
  EXPECT_FALSE(on_file.is_cut());
}

}  // namespace
}  // namespace penumbra
