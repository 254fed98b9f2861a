// The program: what it refuses to start with, the tokens that it makes, and what it writes.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/integration/security/guarded_server.h"
#include "tests/support/daemon.h"

namespace penumbra::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

TEST(PenumbradSecurityTest, E05OtherMachinesNeedTlsAndIdentities) {
  for (const char* address : {"0.0.0.0:0", "[::]:0", "192.0.2.1:0"}) {
    Daemon daemon({"--listen", address});
    EXPECT_THAT(daemon.ErrorLine(), AllOf(HasSubstr(address), HasSubstr("without TLS"),
                                          HasSubstr("--tls-certificate")));
    EXPECT_EQ(daemon.Wait(), EXIT_FAILURE);
  }
  GuardedServer files({.tls = true});
  Daemon open({"--listen", "0.0.0.0:0", "--tls-certificate", files.Path("server.pem"), "--tls-key",
               files.Path("server.key")});
  EXPECT_THAT(open.ErrorLine(), AllOf(HasSubstr("admin"), HasSubstr("--tokens")));
  EXPECT_EQ(open.Wait(), EXIT_FAILURE);
}

TEST(PenumbradSecurityTest, RulesForTokensNeedTheKeysThatSignThem) {
  for (const char* option : {"--jwt-issuer", "--jwt-audience"}) {
    Daemon daemon({"--listen", "127.0.0.1:0", "--egl-device", "none", option, "x"});
    EXPECT_THAT(daemon.ErrorLine(), AllOf(HasSubstr("jwt-keys: found none"), HasSubstr(option)));
    EXPECT_EQ(daemon.Wait(), EXIT_FAILURE);
  }
}

TEST(PenumbradSecurityTest, ATokenThatItMakesLetsInAndIsWrittenNowhere) {
  GuardedServer files({.tls = true});
  Daemon maker({"token", "--name", "ana", "--role", "editor", "--scenes", "review-*", "--days", "3",
                "--append", files.Path("tokens")});
  const std::string token = maker.OutputLine();
  EXPECT_EQ(maker.Wait(), 0);
  ASSERT_TRUE(IsBearerToken(token)) << token;
  std::ifstream file(files.Path("tokens"));
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  EXPECT_THAT(text, AllOf(HasSubstr("ana editor review-* 2"), Not(HasSubstr(token))));

  Daemon daemon({"--listen", "127.0.0.1:0", "--egl-device", "none", "--tokens",
                 files.Path("tokens"), "--tls-certificate", files.Path("server.pem"), "--tls-key",
                 files.Path("server.key")});
  const std::string address = daemon.Address();
  ASSERT_FALSE(address.empty());
  EXPECT_EQ(Visitor(address, files.Credentials(), token).Create("review-1"), absl::OkStatus());
  EXPECT_EQ(Visitor(address, files.Credentials(), token).Create("studio").code(),
            absl::StatusCode::kPermissionDenied);
}

TEST(PenumbradSecurityTest, ATokenForNobodyOrNothingIsRefused) {
  for (const auto& [name, role, scenes, option] :
       {std::tuple("a b", "editor", "*", "--name"), std::tuple("ana", "owner", "*", "--role"),
        std::tuple("ana", "editor", "a/b", "--scenes"),
        std::tuple("ana\neve", "editor", "*", "--name")}) {
    Daemon maker({"token", "--name", name, "--role", role, "--scenes", scenes});
    EXPECT_THAT(maker.ErrorLine(), StartsWith(std::string("penumbrad: command line: ") + option));
    EXPECT_EQ(maker.OutputLine(), "");
    EXPECT_EQ(maker.Wait(), EXIT_FAILURE);
  }
}

// E08: nothing that a client sends is written as it is, and no credential at all.
TEST(PenumbradSecurityTest, E08ClientsDoNotWriteIntoTheRecords) {
  GuardedServer files;
  const std::string token = files.Admit("ana", "editor", "*");
  Daemon daemon(
      {"--listen", "127.0.0.1:0", "--egl-device", "none", "--tokens", files.Path("tokens")});
  const std::string address = daemon.Address();
  const std::string hostile = "x\r\n{\"level\":\"error\"}\x1b[2J%s%n{}";
  Visitor ana(address, grpc::InsecureChannelCredentials(), token);
  EXPECT_EQ(ana.Create("studio"), absl::OkStatus());
  EXPECT_EQ(ana.Create(hostile).code(), absl::StatusCode::kInvalidArgument);
  const auto session = ana.Open("Session");
  v1::SessionRequest request;
  request.mutable_hello()->add_protocol_versions(1);
  request.mutable_hello()->set_scene_id("studio");
  request.mutable_hello()->set_client_name(hostile);
  session->Send(request);
  v1::SessionResponse response;
  EXPECT_TRUE(session->Read(response));
  const std::string wrong = MakeBearerToken();
  Visitor(address, grpc::InsecureChannelCredentials(), wrong).Create("other").IgnoreError();
  daemon.Signal(SIGTERM);
  EXPECT_EQ(session->End().code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(daemon.Wait(), 0);
  for (std::string line = daemon.ErrorLine(); !line.empty(); line = daemon.ErrorLine()) {
    EXPECT_THAT(line, AllOf(Not(HasSubstr(token)), Not(HasSubstr(wrong)), Not(HasSubstr("\x1b")),
                            Not(HasSubstr("\r")), Not(StartsWith("{\"level\""))));
  }
}

}  // namespace
}  // namespace penumbra::testing
