// E04: twelve identities × every call and every request of a session × (TLS, loopback).

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <map>
#include <set>

#include "proto/convert/geometry_convert.h"
#include "proto/convert/scene_convert.h"
#include "proto/convert/status_convert.h"
#include "server/security/rpc_roles.h"
#include "tests/integration/security/guarded_server.h"
#include "tests/support/jwt_signer.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {
namespace {

constexpr std::array<const char*, 12> kIdentities = {
    "nobody",          "a malformed token", "an unknown token", "an expired token",
    "viewer of all",   "viewer in scope",   "viewer outside",   "editor of all",
    "editor in scope", "editor outside",    "admin of all",     "admin outside"};

// What each gets, in that order: Unauthenticated, Denied, Not found, ok. Written by hand, so that a
// row of rpc_roles.cc that is wrong does not make itself right.
const std::map<std::string, std::string> kExpected = {
    {"Session", "UUUU ooN ooN oN"},
    {"CreateScene", "UUUU DDD ooD oD"},
    {"ListScenes", "UUUU ooo ooo oo"},
    {"DeleteScene", "UUUU DDD ooN oN"},
    {"GetServerInfo", "UUUU ooo ooo oo"},
    {"GetServerStatus", "UUUU DDD DDD oo"},
    {"ListTechniques", "UUUU ooo ooo oo"},
    {"FindMissingBlobs", "UUUU DDD ooo oo"},
    {"UploadBlob", "UUUU DDD ooo oo"},
    {"DownloadBlob", "UUUU ooN ooN oN"},
    {"ExportScene", "UUUU DDD ooN oN"},
    {"ImportScene", "UUUU DDD ooD oD"},
    {"Session.hello", "UUUU ooN ooN oN"},
    {"Session.commit", "UUUU DDN ooN oN"},
    {"Session.subscribe", "UUUU ooN ooN oN"},
    {"Session.unsubscribe", "UUUU ooN ooN oN"},
    {"Session.credit", "UUUU ooN ooN oN"},
    {"Session.acknowledgement", "UUUU ooN ooN oN"},
    {"Session.view_report", "UUUU ooN ooN oN"},
    {"Session.subscribe_each", "UUUU ooN ooN oN"},
    {"Session.presence", "UUUU ooN ooN oN"},
    {"Session.edit_control", "UUUU DDN ooN oN"},
};

char LetterOf(const absl::Status& status) {
  switch (status.code()) {
    case absl::StatusCode::kUnauthenticated:
      return 'U';
    case absl::StatusCode::kPermissionDenied:
      return 'D';
    case absl::StatusCode::kNotFound:
      return 'N';
    default:
      return 'o';  // let in; what became of an empty request is no matter here
  }
}

std::shared_ptr<const Mesh> BoxOf(float size) {
  MeshGeometry box = UnitBoxGeometry();
  for (auto& position : box.positions) position *= size;
  return MeshOf(box);
}

// The scene "review-1", with one box in it that nobody else has, and what each identity shows.
class MatrixTest : public ::testing::TestWithParam<bool> {
 protected:
  MatrixTest() : server_({.tls = GetParam(), .jwt_keys = KeySetOf({rsa_, ec_})}) {}

  void SetUp() override {
    shown_ = {"",
              "malformed",
              MakeBearerToken(),
              server_.Admit("old", "admin", "*", "2020-01-01T00:00:00Z"),
              server_.Admit("v1", "viewer", "*"),
              rsa_.Sign(Claims("v2", "viewer", "review-*")),
              server_.Admit("v3", "viewer", "other-*"),
              server_.Admit("e1", "editor", "*"),
              ec_.Sign(Claims("e2", "editor", "review-*")),
              server_.Admit("e3", "editor", "other-*"),
              server_.Admit("a1", "admin", "*"),
              server_.Admit("a2", "admin", "other-*")};
    server_.Start();
    MakeScene("review-1", 1.0f);
  }

  static nlohmann::json Claims(const char* name, const char* role, const char* scenes) {
    const auto later = std::chrono::system_clock::now() + std::chrono::hours(1);
    return {{"iss", "https://id.example"},
            {"aud", "penumbra"},
            {"exp", std::chrono::system_clock::to_time_t(later)},
            {"sub", name},
            {"penumbra_role", role},
            {"penumbra_scenes", scenes}};
  }

  Visitor Admin() { return server_.Visit(shown_[10]); }

  void MakeScene(const std::string& id, float size) {
    Visitor admin = Admin();
    ASSERT_EQ(admin.Create(id), absl::OkStatus());
    ASSERT_EQ(admin.Upload(*BoxOf(size)), absl::OkStatus());
    SceneDelta delta;
    delta.upsert_instances = {{.id = "box", .mesh = BoxOf(size)}};
    const auto session = admin.Open("Session");
    ASSERT_EQ(admin.Hello(*session, id), absl::OkStatus());
    ASSERT_EQ(admin.Commit(*session, ToProto(delta)), absl::OkStatus());
    session->SendNoMore();
    EXPECT_EQ(session->End(), absl::OkStatus());
  }

  absl::Status Try(const std::string& name, size_t identity) {
    Visitor visitor = server_.Visit(shown_[identity]);
    if (name.starts_with("Session.")) return TryInSession(visitor, name.substr(8));
    if (name == "Session") {
      const auto session = visitor.Open(name);
      return visitor.Hello(*session, "review-1");
    }
    if (name == "CreateScene") return visitor.Create("review-" + shown_[identity].substr(0, 100));
    if (name == "UploadBlob") return visitor.Upload(*BoxOf(2.0f + static_cast<float>(identity)));
    if (name == "DownloadBlob") return visitor.Download(*BoxOf(1.0f));
    if (name == "DeleteScene") {
      const auto status = visitor.Delete("review-1");
      if (status.ok()) MakeScene("review-1", 1.0f);
      return status;
    }
    if (name == "ExportScene") return visitor.Export("review-1");
    if (name == "ImportScene") return visitor.Import("review-2");
    if (name == "FindMissingBlobs") {
      v1::FindMissingBlobsRequest request;
      request.add_hashes(ToProto(BoxOf(1.0f)->id()));
      return visitor.Call(name, request);
    }
    return visitor.Call(name, v1::ListScenesRequest());
  }

  // An empty request of that kind, after a good hello, and what it is answered.
  absl::Status TryInSession(Visitor& visitor, const std::string& kind) {
    const auto session = visitor.Open("Session");
    if (auto status = visitor.Hello(*session, "review-1"); !status.ok() || kind == "hello") {
      return status;
    }
    v1::SessionRequest request;
    const auto* field = v1::SessionRequest::descriptor()->FindFieldByName(kind);
    request.GetReflection()->MutableMessage(&request, field);
    session->Send(request);
    session->SendNoMore();
    absl::Status answer;
    v1::SessionResponse response;
    while (session->Read(response)) {
      if (response.has_session_error()) answer = FromProto(response.session_error().error());
      if (response.has_commit_result()) answer = FromProto(response.commit_result().error());
    }
    // Of an empty request, not of the scene.
    return absl::IsNotFound(answer) ? absl::OkStatus() : answer;
  }

  const JwtSigner rsa_ = JwtSigner::Rsa("rsa");
  const JwtSigner ec_ = JwtSigner::Ec("ec");
  GuardedServer server_;
  std::vector<std::string> shown_;
};

TEST_P(MatrixTest, E04EveryIdentityGetsWhatTheTableSaysOfEveryCall) {
  int cells = 0;
  for (const auto& [name, letters] : kExpected) {
    std::string expected = letters;
    std::erase(expected, ' ');
    ASSERT_EQ(expected.size(), kIdentities.size()) << name;
    for (size_t identity = 0; identity < kIdentities.size(); ++identity, ++cells) {
      SCOPED_TRACE(
          absl::StrCat(name, " × ", kIdentities[identity], " × ", GetParam() ? "TLS" : "loopback"));
      const auto status = Try(name, identity);
      EXPECT_EQ(LetterOf(status), expected[identity]) << status;
    }
  }
  std::printf("%d cells of %zu\n", cells, kExpected.size() * kIdentities.size());
}

TEST_P(MatrixTest, E04TheExpectationsAreOfEveryCallThereIs) {
  std::set<std::string> names;
  for (const auto& [name, letters] : kExpected) names.insert(name);
  const auto* service = v1::CreateSceneRequest::descriptor()->file()->service(0);
  for (int i = 0; i < service->method_count(); ++i) {
    EXPECT_EQ(names.erase(service->method(i)->name()), 1u) << service->method(i)->name();
  }
  const auto* requests = v1::SessionRequest::descriptor()->FindOneofByName("request");
  for (int i = 0; i < requests->field_count(); ++i) {
    EXPECT_EQ(names.erase("Session." + requests->field(i)->name()), 1u)
        << requests->field(i)->name();
  }
  EXPECT_THAT(names, ::testing::IsEmpty());
}

INSTANTIATE_TEST_SUITE_P(Over, MatrixTest, ::testing::Bool(),
                         [](const auto& param) { return param.param ? "Tls" : "Loopback"; });

}  // namespace
}  // namespace penumbra::testing
