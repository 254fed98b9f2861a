#include "server/listen_address.h"

#include <gtest/gtest.h>

#include "render/scene/field_error.h"

namespace penumbra {
namespace {

TEST(ListenAddressTest, LoopbackAndSocketFilesAreGood) {
  for (const char* good : {"127.0.0.1:0", "127.1.2.3:7717", "localhost:65535", "[::1]:80",
                           "unix:/tmp/penumbra", "unix:relative"}) {
    EXPECT_EQ(CheckListenAddress(good), absl::OkStatus()) << good;
    EXPECT_TRUE(IsLocalAddress(good)) << good;
  }
}

TEST(ListenAddressTest, WhatIsNoAddressIsRefused) {
  for (const char* bad : {"", ":80", "::1:80", "127.0.0.1", "127.0.0.1:", "127.0.0.1:65536",
                          "127.0.0.1:-1", "127.0.0.1:80x", "unix:", "[::]80"}) {
    for (const bool has_tls : {false, true}) {
      const auto status = CheckListenAddress(bad, has_tls);
      EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << bad;
      EXPECT_EQ(ErrorReason(status), "BAD_ADDRESS") << bad;
      EXPECT_EQ(ErrorFieldPath(status), "listen");
    }
  }
}

// E05: a listener without encryption is on this machine alone.
TEST(ListenAddressTest, E05OtherMachinesNeedTls) {
  for (const char* open : {"0.0.0.0:80", "[::]:80", "192.168.0.1:80", "example.org:80",
                           "127.lan:80", "127.1:80", "localhost.example.org:80", "[::2]:80"}) {
    const auto status = CheckListenAddress(open);
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << open;
    EXPECT_EQ(ErrorReason(status), "NEEDS_TLS") << open;
    EXPECT_NE(status.message().find("--tls-certificate"), std::string::npos);
    EXPECT_FALSE(IsLocalAddress(open)) << open;
    EXPECT_EQ(CheckListenAddress(open, /*has_tls=*/true), absl::OkStatus()) << open;
  }
}

TEST(ListenAddressTest, TryingTellsWhy) {
  EXPECT_EQ(TryListening("127.0.0.1:0"), absl::OkStatus());
  EXPECT_EQ(ErrorReason(TryListening("unix:/no/such/folder/socket")), "CANNOT_LISTEN");
}

}  // namespace
}  // namespace penumbra
