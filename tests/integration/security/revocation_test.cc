// E03: a stream ends soon after its caller's right does.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <future>
#include <thread>

#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "proto/convert/scene_convert.h"
#include "render/scene/field_error.h"
#include "tests/integration/security/guarded_server.h"
#include "tests/support/jwt_signer.h"
#include "tests/support/shapes.h"
#include "tests/support/small_archive.h"

namespace penumbra::testing {
namespace {

using Clock = std::chrono::steady_clock;

double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

std::string InSeconds(int seconds) {
  return absl::FormatTime("%Y-%m-%dT%H:%M:%SZ", absl::Now() + absl::Seconds(seconds),
                          absl::UTCTimeZone());
}

// The interval of the program: what is stated is stated of it.
GuardedServerOptions AsShipped() { return {.look_interval = SecurityOptions().look_interval}; }

TEST(RevocationTest, E03ASessionEndsWhenItsTokenLeavesTheFile) {
  GuardedServer server(AsShipped());
  const std::string token = server.Admit("ana", "editor", "*");
  const std::string stays = server.Admit("ben", "viewer", "*");
  server.Start();
  Visitor ana = server.Visit(token), ben = server.Visit(stays);
  ASSERT_EQ(ana.Create("studio"), absl::OkStatus());
  const auto session = ana.Open("Session"), other = ben.Open("Session");
  ASSERT_EQ(ana.Hello(*session, "studio"), absl::OkStatus());
  ASSERT_EQ(ben.Hello(*other, "studio"), absl::OkStatus());
  const auto upload = ana.Open("UploadBlob");

  server.ForgetAll();
  server.AddLine(absl::StrCat("token sha256:", HashOfToken(stays).hex(), " ben viewer *"));
  const auto start = Clock::now();
  const auto ended = session->End();
  EXPECT_EQ(ended.code(), absl::StatusCode::kUnauthenticated) << ended;
  EXPECT_EQ(ErrorReason(ended), "UNAUTHENTICATED");
  EXPECT_FALSE(upload->End().ok());
  EXPECT_LT(SecondsSince(start), 5.0);
  EXPECT_EQ(ana.Create("second").code(), absl::StatusCode::kUnauthenticated);
  // The other one has noticed nothing.
  EXPECT_EQ(ben.Commit(*other, v1::SceneDelta()).code(), absl::StatusCode::kPermissionDenied);
}

TEST(RevocationTest, E03ASessionEndsWhenItsTokenExpires) {
  GuardedServer server(AsShipped());
  const std::string token = server.Admit("ana", "editor", "*", InSeconds(3));
  server.Start();
  Visitor ana = server.Visit(token);
  ASSERT_EQ(ana.Create("studio"), absl::OkStatus());
  const auto session = ana.Open("Session");
  ASSERT_EQ(ana.Hello(*session, "studio"), absl::OkStatus());
  const auto start = Clock::now();
  EXPECT_EQ(session->End().code(), absl::StatusCode::kUnauthenticated);
  EXPECT_LT(SecondsSince(start), 3.0 + 5.0);
}

TEST(RevocationTest, E03ASessionWhoseClientDoesNotReadIsCancelled) {
  GuardedServer server;
  const std::string token = server.Admit("ana", "editor", "*");
  const std::string admin = server.Admit("root", "admin", "*");
  server.Start();
  Visitor ana = server.Visit(token), root = server.Visit(admin);
  ASSERT_EQ(root.Create("studio"), absl::OkStatus());
  const auto session = ana.Open("Session");
  v1::SessionRequest hello;
  hello.mutable_hello()->add_protocol_versions(1);
  hello.mutable_hello()->set_scene_id("studio");
  session->Send(hello);  // and no reading of what comes
  const auto open_sessions = [&] {
    v1::GetServerInfoResponse info;
    EXPECT_EQ(root.Call("GetServerInfo", v1::GetServerInfoRequest(), &info), absl::OkStatus());
    return info.statistics().open_sessions();
  };
  const auto start = Clock::now();
  while (open_sessions() == 0 && SecondsSince(start) < 10.0) {
  }
  ASSERT_EQ(open_sessions(), 1u);
  server.ForgetAll();
  server.AddLine(absl::StrCat("token sha256:", HashOfToken(admin).hex(), " root admin *"));
  const auto revoked = Clock::now();
  while (open_sessions() > 0 && SecondsSince(revoked) < 10.0) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  EXPECT_LT(SecondsSince(revoked), 5.0);
}

TEST(RevocationTest, E03LessRightsEndASessionAndMoreTimeDoesNot) {
  GuardedServer server;
  const std::string ana = server.Admit("ana", "editor", "*");
  const std::string ben = server.Admit("ben", "editor", "*", InSeconds(600));
  server.Start();
  Visitor first = server.Visit(ana), second = server.Visit(ben);
  ASSERT_EQ(first.Create("studio"), absl::OkStatus());
  const auto session = first.Open("Session"), other = second.Open("Session");
  ASSERT_EQ(first.Hello(*session, "studio"), absl::OkStatus());
  ASSERT_EQ(second.Hello(*other, "studio"), absl::OkStatus());
  server.ForgetAll();
  server.Replace("tokens", absl::StrCat("token sha256:", HashOfToken(ana).hex(), " ana viewer *\n",
                                        "token sha256:", HashOfToken(ben).hex(), " ben editor * ",
                                        InSeconds(6'000), "\n"));
  EXPECT_EQ(session->End().code(), absl::StatusCode::kUnauthenticated);
  EXPECT_EQ(second.Commit(*other, v1::SceneDelta()), absl::OkStatus());
}

TEST(RevocationTest, E03AKeyThatLeavesTheSetTakesItsTokensAlong) {
  const JwtSigner old = JwtSigner::Ec("old"), young = JwtSigner::Ec("young");
  GuardedServer server({.jwt_keys = KeySetOf({old})});
  server.Start();
  const auto later = std::chrono::system_clock::now() + std::chrono::hours(1);
  const nlohmann::json claims = {{"iss", "https://id.example"},
                                 {"aud", "penumbra"},
                                 {"exp", std::chrono::system_clock::to_time_t(later)},
                                 {"sub", "ana"},
                                 {"penumbra_role", "editor"},
                                 {"penumbra_scenes", "*"}};
  Visitor ana = server.Visit(old.Sign(claims));
  ASSERT_EQ(ana.Create("studio"), absl::OkStatus());
  const auto session = ana.Open("Session");
  ASSERT_EQ(ana.Hello(*session, "studio"), absl::OkStatus());
  server.Replace("keys.json", KeySetOf({young}));
  EXPECT_EQ(session->End().code(), absl::StatusCode::kUnauthenticated);
  EXPECT_EQ(server.Visit(young.Sign(claims)).Create("second"), absl::OkStatus());
}

TEST(RevocationTest, E03AnImportIsNotMadeOnceItsTokenHasExpired) {
  GuardedServer server;
  const std::string token = server.Admit("ana", "editor", "*", InSeconds(5));
  const std::string admin = server.Admit("root", "admin", "*");
  server.Start();
  Visitor ana = server.Visit(token), root = server.Visit(admin);
  ASSERT_EQ(ana.Upload(*BoxAndLamp(1).upsert_instances[0].mesh), absl::OkStatus());
  v1::ImportSceneRequest request;
  for (const auto& record : SmallImport()) *request.add_records() = record;
  request.set_scene_id("in-time");
  EXPECT_EQ(ana.Call("ImportScene", request), absl::OkStatus());
  const auto late = ana.Open("ImportScene");
  request.set_scene_id("late");
  late->Send(request);
  std::this_thread::sleep_for(std::chrono::seconds(7));
  late->SendNoMore();
  EXPECT_FALSE(late->End().ok());
  EXPECT_EQ(root.List(), std::vector<std::string>{"in-time"});
}

TEST(RevocationTest, AFileThatHasBecomeWrongIsToldOfAndChangesNothing) {
  GuardedServer server;
  const std::string token = server.Admit("ana", "editor", "*");
  std::promise<std::string> problem;
  std::atomic<int> problems = 0;
  ServerOptions options = server.Options();
  options.security.on_problem = [&](const std::string& text) {
    if (++problems == 1) problem.set_value(text);
  };
  server.Start(options);
  server.AddLine("token nonsense");
  auto told = problem.get_future();
  ASSERT_EQ(told.wait_for(std::chrono::seconds(5)), std::future_status::ready);
  EXPECT_THAT(told.get(), ::testing::HasSubstr("tokens:2"));
  EXPECT_EQ(server.Visit(token).Create("studio"), absl::OkStatus());
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  EXPECT_EQ(problems, 1) << "once, not each time it is looked at";
}

}  // namespace
}  // namespace penumbra::testing
