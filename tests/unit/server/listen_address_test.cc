#include "server/listen_address.h"

#include <gtest/gtest.h>

#include "render/scene/field_error.h"

namespace penumbra {
namespace {

TEST(ListenAddressTest, LoopbackAndSocketFilesAreGood) {
  for (const char* good : {"127.0.0.1:0", "127.1.2.3:7717", "localhost:65535", "[::1]:80",
                           "unix:/tmp/penumbra", "unix:relative"}) {
    EXPECT_EQ(CheckListenAddress(good), absl::OkStatus()) << good;
  }
}

TEST(ListenAddressTest, EverythingElseIsRefused) {
  for (const char* bad :
       {"", ":80", "0.0.0.0:80", "[::]:80", "::1:80", "192.168.0.1:80", "example.org:80",
        "127.0.0.1", "127.0.0.1:", "127.0.0.1:65536", "127.0.0.1:-1", "127.0.0.1:80x", "127.lan:80",
        "127.1:80", "unix:", "localhost.example.org:80"}) {
    const auto status = CheckListenAddress(bad);
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << bad;
    EXPECT_EQ(ErrorReason(status), "BAD_ADDRESS") << bad;
    EXPECT_EQ(ErrorFieldPath(status), "listen");
  }
}

TEST(ListenAddressTest, TryingTellsWhy) {
  EXPECT_EQ(TryListening("127.0.0.1:0"), absl::OkStatus());
  EXPECT_EQ(ErrorReason(TryListening("unix:/no/such/folder/socket")), "CANNOT_LISTEN");
}

}  // namespace
}  // namespace penumbra
