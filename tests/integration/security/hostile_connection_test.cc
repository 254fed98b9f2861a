// C05: a request that never ends, of a client that answers all pings, is nothing to gRPC's timers.

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <string>
#include <thread>

#include "tests/integration/security/guarded_server.h"

namespace penumbra::testing {
namespace {

using std::chrono::milliseconds, std::chrono::steady_clock;

// A literal of HPACK, without indexing and without Huffman's code.
std::string Header(const std::string& name, const std::string& value) {
  return std::string(1, '\0') + static_cast<char>(name.size()) + name +
         static_cast<char>(value.size()) + value;
}

std::string Frame(char kind, char flags, char stream, const std::string& payload) {
  const auto size = static_cast<unsigned>(payload.size());
  std::string frame = {static_cast<char>(size >> 16),
                       static_cast<char>(size >> 8),
                       static_cast<char>(size),
                       kind,
                       flags,
                       0,
                       0,
                       0,
                       stream};
  return frame + payload;
}

// A message of a thousand bytes, of which ten come.
std::string EndlessRequest() {
  const std::string headers = Header(":method", "POST") + Header(":scheme", "http") +
                              Header(":path", "/penumbra.v1.PenumbraService/CreateScene") +
                              Header(":authority", "localhost") +
                              Header("content-type", "application/grpc") + Header("te", "trailers");
  const std::string start = {0, 0, 0, 3, static_cast<char>(0xe8)};
  return "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + Frame(4, 0, 0, "") + Frame(4, 1, 0, "") +
         Frame(1, 4, 1, headers) + Frame(0, 0, 1, start + std::string(10, 'a'));
}

int ConnectTo(const std::string& address) {
  sockaddr_in name{};
  name.sin_family = AF_INET;
  name.sin_port = htons(static_cast<uint16_t>(std::stoi(address.substr(address.rfind(':') + 1))));
  name.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const int fd = socket(AF_INET, SOCK_STREAM, 0);
  EXPECT_EQ(connect(fd, reinterpret_cast<sockaddr*>(&name), sizeof(name)), 0);
  return fd;
}

// Whether the other side closes within that time; more bytes of the body go out in the meantime.
bool IsClosedWithin(int fd, milliseconds limit) {
  const auto end = steady_clock::now() + limit;
  char buffer[4096];
  while (steady_clock::now() < end) {
    pollfd polled = {.fd = fd, .events = POLLIN, .revents = 0};
    if (poll(&polled, 1, 100) > 0 && recv(fd, buffer, sizeof(buffer), 0) <= 0) return true;
    const std::string more = Frame(0, 0, 1, "a");
    send(fd, more.data(), more.size(), MSG_NOSIGNAL);
  }
  return false;
}

TEST(HostileConnectionTest, C05ABodyThatDribblesIsCutAndGuestsStay) {
  GuardedServer server;
  const std::string token = server.Admit("ana", "editor", "*");
  ServerOptions options = server.Options();
  options.security.connections.stranger_timeout = milliseconds(1'500);
  server.Start(options);
  Visitor ana = server.Visit(token);
  ASSERT_EQ(ana.Create("studio"), absl::OkStatus());
  const auto session = ana.Open("Session");
  ASSERT_EQ(ana.Hello(*session, "studio"), absl::OkStatus());

  const int fd = ConnectTo(server.address());
  const std::string request = EndlessRequest();
  ASSERT_EQ(send(fd, request.data(), request.size(), MSG_NOSIGNAL),
            static_cast<ssize_t>(request.size()));
  EXPECT_FALSE(IsClosedWithin(fd, milliseconds(1'000)));
  EXPECT_TRUE(IsClosedWithin(fd, milliseconds(5'000)));
  close(fd);
  // Who has been let in once may be quiet.
  EXPECT_EQ(ana.Commit(*session, v1::SceneDelta()), absl::OkStatus());
}

}  // namespace
}  // namespace penumbra::testing
