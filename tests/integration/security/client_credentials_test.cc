// What the client library shows, and where it does not.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/session/remote_engine.h"
#include "render/scene/field_error.h"
#include "tests/integration/security/guarded_server.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {
namespace {

using ::testing::HasSubstr;

// All that an engine calls, with a token that is needed for each of it.
void UseAll(const GuardedServer& server, const ClientCredentials& credentials) {
  const auto engine =
      RemoteEngine::Connect({.address = server.address(), .credentials = credentials});
  ASSERT_TRUE(engine.ok()) << engine.status();
  ASSERT_EQ((*engine)->CreateScene("studio"), absl::OkStatus());
  SceneDelta delta;
  delta.upsert_instances = {{.id = "box", .mesh = MeshOf(UnitBoxGeometry())}};
  EXPECT_TRUE((*engine)->Commit("studio", delta).ok());
  // Another one has to fetch the mesh.
  const auto other =
      RemoteEngine::Connect({.address = server.address(), .credentials = credentials});
  ASSERT_TRUE(other.ok()) << other.status();
  const auto scene = (*other)->Snapshot("studio");
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_EQ((*scene)->instances().size(), 1u);
  EXPECT_EQ((*engine)->DeleteScene("studio"), absl::OkStatus());
}

TEST(ClientCredentialsTest, EveryCallShowsTheToken) {
  for (const bool tls : {false, true}) {
    GuardedServer server({.tls = tls});
    const std::string token = server.Admit("ana", "editor", "*");
    server.Start();
    UseAll(server, {.token = token, .tls = tls, .ca_file = tls ? server.Path("ca.pem") : ""});
    const auto stranger = RemoteEngine::Connect(
        {.address = server.address(),
         .credentials = {.tls = tls, .ca_file = tls ? server.Path("ca.pem") : ""}});
    EXPECT_EQ(stranger.status().code(), absl::StatusCode::kUnauthenticated) << stranger.status();
  }
}

TEST(ClientCredentialsTest, ACertificateIsShown) {
  GuardedServer server({.tls = true, .asks_for_certificates = true});
  server.AddLine("certificate cn:desk desk editor *");
  const auto own = server.authority().Issue({.common_name = "desk"});
  server.Replace("own.pem", own.certificate);
  server.Replace("own.key", own.key);
  server.Start();
  UseAll(server, {.tls = true,
                  .ca_file = server.Path("ca.pem"),
                  .certificate_file = server.Path("own.pem"),
                  .key_file = server.Path("own.key")});
}

TEST(ClientCredentialsTest, ATokenGoesToOtherMachinesOverTlsAlone) {
  const std::string token = MakeBearerToken();
  for (const char* address :
       {"192.0.2.1:7717", "example.org:7717", "127.example.org:7717", "127.0.0.1.example.org:7717",
        "localhost.example.org:7717", "dns:127.0.0.1:7717"}) {
    const auto engine =
        RemoteEngine::Connect({.address = address, .credentials = {.token = token}});
    EXPECT_EQ(ErrorReason(engine.status()), "NEEDS_TLS") << address;
    EXPECT_THAT(std::string(engine.status().message()), Not(HasSubstr(token)));
  }
}

TEST(ClientCredentialsTest, WhatCannotBeShownIsAnErrorWithoutIt) {
  const auto reason = [](const ClientCredentials& credentials) {
    const auto status =
        RemoteEngine::Connect({.address = "127.0.0.1:1", .credentials = credentials}).status();
    EXPECT_THAT(std::string(status.message()), Not(HasSubstr("secret")));
    return ErrorReason(status) + " " + ErrorFieldPath(status);
  };
  EXPECT_EQ(reason({.token = "secret\r\nx: y"}), "BAD_TOKEN token");
  EXPECT_EQ(reason({.token = "secret secret"}), "BAD_TOKEN token");
  EXPECT_EQ(reason({.tls = true, .ca_file = "/no/such/file"}), "CANNOT_READ tls-ca");
  EXPECT_EQ(reason({.tls = true, .certificate_file = "/no/such/file"}), "MISSING_FIELD tls-key");
  EXPECT_EQ(reason({.tls = true, .key_file = "/no/such/file"}), "MISSING_FIELD tls-certificate");
}

}  // namespace
}  // namespace penumbra::testing
