// E01: whatever is wrong with what a caller shows, the answer is the same.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <mutex>

#include "render/scene/field_error.h"
#include "tests/integration/security/guarded_server.h"
#include "tests/support/jwt_signer.h"

namespace penumbra::testing {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

int64_t UnixNow() {
  return std::chrono::duration_cast<std::chrono::seconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

nlohmann::json Claims() {
  return {{"iss", "https://id.example"}, {"aud", "penumbra"},         {"exp", UnixNow() + 600},
          {"sub", "ana@example"},        {"penumbra_role", "editor"}, {"penumbra_scenes", "*"}};
}

nlohmann::json With(const char* name, const nlohmann::json& value) {
  auto claims = Claims();
  claims[name] = value;
  return claims;
}

TEST(AuthenticationTest, WithoutIdentitiesEveryoneHereIsAnAdmin) {
  ServerOptions options;
  options.listen = "127.0.0.1:0";
  options.opens_gl = false;
  const auto server = PenumbraServer::Start(options).value();
  Visitor anyone(server->address(), grpc::InsecureChannelCredentials(), "");
  EXPECT_EQ(anyone.Create("studio"), absl::OkStatus());
  EXPECT_THAT(anyone.List(), ElementsAre("studio"));
  // What is shown to a server that asks for nothing is not looked at.
  Visitor stranger(server->address(), grpc::InsecureChannelCredentials(), "whatever");
  EXPECT_EQ(stranger.Delete("studio"), absl::OkStatus());
}

// What is wrong, each as the values of the header "authorization".
std::vector<std::vector<std::string>> WrongHeaders(const JwtSigner& rsa, const std::string& good,
                                                   const std::string& expired) {
  const auto bearer = [](const std::string& token) { return "Bearer " + token; };
  const auto jwt = [&](const nlohmann::json& claims) { return bearer(rsa.Sign(claims)); };
  const auto forged = [&](const char* algorithm, const char* key) {
    return bearer(rsa.SignAs({{"alg", algorithm}, {"kid", key}}, Claims()));
  };
  return {{},                            // nothing
          {""},                          // an empty header
          {"Bearer "},                   // an empty token
          {"Basic " + good},             // another scheme
          {good},                        // no scheme
          {bearer(good), bearer(good)},  // two
          {bearer(" " + good)},          // a blank too many
          {bearer(good.substr(0, good.size() - 1))},
          {bearer(MakeBearerToken())},  // unknown
          {bearer(expired)},
          {forged("none", "rsa")},
          {forged("HS256", "rsa")},
          {forged("RS256", "none")},
          {bearer(JwtSigner::Rsa("rsa").Sign(Claims()))},  // a wrong signature
          {jwt(With("exp", UnixNow() - 61))},
          {jwt(With("nbf", UnixNow() + 120))},
          {jwt(With("iss", "https://evil.example"))},
          {jwt(With("aud", "others"))}};
}

class WrongCredentialsTest : public ::testing::TestWithParam<bool> {};

TEST_P(WrongCredentialsTest, E01AllThatIsWrongGetsOneAnswer) {
  const JwtSigner rsa = JwtSigner::Rsa("rsa");
  GuardedServer server({.tls = GetParam(), .jwt_keys = rsa.KeySet()});
  const std::string good = server.Admit("ana", "admin", "*");
  const std::string expired = server.Admit("old", "admin", "*", "2020-01-01T00:00:00Z");
  std::mutex mutex;
  std::vector<std::string> told;
  ServerOptions options = server.Options();
  options.security.on_refused = [&](const RefusedCall& call) {
    std::lock_guard lock(mutex);
    told.push_back(std::string(call.call) + " " + call.why);
  };
  server.Start(options);
  ASSERT_EQ(server.Visit(good).Create("studio"), absl::OkStatus());
  ASSERT_EQ(server.Visit(rsa.Sign(Claims())).Create("other"), absl::OkStatus());

  const auto first = server.Visit("").Create("studio");
  const auto wrong = WrongHeaders(rsa, good, expired);
  for (size_t i = 0; i < wrong.size(); ++i) {
    Visitor visitor = server.Visit("");
    visitor.ShowInstead(wrong[i]);
    const auto status = visitor.Create("studio");
    EXPECT_EQ(status.code(), absl::StatusCode::kUnauthenticated) << i << status;
    EXPECT_EQ(ErrorReason(status), "UNAUTHENTICATED") << i;
    EXPECT_EQ(status, first) << i << ": another text tells what was wrong";
    // The same connection goes on.
    visitor.ShowInstead({"bearer " + good});
    EXPECT_EQ(visitor.Call("ListScenes", v1::ListScenesRequest()), absl::OkStatus()) << i;
  }
  std::lock_guard lock(mutex);
  EXPECT_EQ(told.size(), wrong.size() + 1);
  EXPECT_THAT(told, ::testing::Contains("CreateScene expired"));
  EXPECT_THAT(told, Each(Not(HasSubstr("penumbra_")))) << "records hold no token";
}

INSTANTIATE_TEST_SUITE_P(Over, WrongCredentialsTest, ::testing::Bool(),
                         [](const auto& param) { return param.param ? "Tls" : "Loopback"; });

TEST(AuthenticationTest, ACertificateIsAnIdentityWhereTheFileSaysSo) {
  GuardedServer server({.tls = true, .asks_for_certificates = true});
  server.AddLine("certificate cn:render-01 farm viewer *");
  server.AddLine("certificate dns:edit.example desk editor *");
  const std::string token = server.Admit("ana", "editor", "*");
  server.Start();
  const auto& ca = server.authority();
  const auto farm = ca.Issue({.common_name = "render-01"});
  const auto desk = ca.Issue({.common_name = "x", .alternative_names = "DNS:edit.example"});
  const auto other =
      ca.Issue({.common_name = "edit.example", .alternative_names = "DNS:render-01"});
  EXPECT_EQ(server.Visit("", desk).Create("studio"), absl::OkStatus());
  EXPECT_THAT(server.Visit("", farm).List(), ElementsAre("studio"));
  EXPECT_EQ(server.Visit("", farm).Create("other").code(), absl::StatusCode::kPermissionDenied);
  EXPECT_EQ(server.Visit("", other).Create("other").code(), absl::StatusCode::kUnauthenticated);
  // A token says more than a certificate; a wrong one is not overlooked for it.
  EXPECT_EQ(server.Visit(token, farm).Create("third"), absl::OkStatus());
  EXPECT_EQ(server.Visit(MakeBearerToken(), desk).Create("fourth").code(),
            absl::StatusCode::kUnauthenticated);
}

}  // namespace
}  // namespace penumbra::testing
