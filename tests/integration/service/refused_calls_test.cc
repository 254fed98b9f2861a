// What bad calls and bad bytes get, and that nothing else is the worse for it.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"
#include "proto/convert/geometry_convert.h"
#include "proto/convert/status_convert.h"
#include "render/scene/blob.h"
#include "render/scene/field_error.h"
#include "tests/integration/service/studio.h"

namespace penumbra::testing {
namespace {

using ::testing::HasSubstr;

MATCHER_P3(IsRefused, code, reason, field, "") {
  return arg.code() == code && ErrorReason(arg) == reason && ErrorFieldPath(arg) == field;
}

TEST_F(StudioTest, ScenesAreMadeListedAndDeleted) {
  EXPECT_THAT(client_->CreateScene("studio"),
              IsRefused(absl::StatusCode::kAlreadyExists, "DUPLICATE_ID", "scene_id"));
  EXPECT_THAT(client_->CreateScene(""),
              IsRefused(absl::StatusCode::kInvalidArgument, "BAD_ID", "scene_id"));
  EXPECT_THAT(client_->CreateScene("a/b"),
              IsRefused(absl::StatusCode::kInvalidArgument, "BAD_ID", "scene_id"));
  EXPECT_THAT(client_->DeleteScene("ghost"),
              IsRefused(absl::StatusCode::kNotFound, "UNKNOWN_ID", "scene_id"));
  EXPECT_EQ(client_->CreateScene("second"), absl::OkStatus());
  EXPECT_EQ(client_->ListScenes()->size(), 2u);
  EXPECT_EQ(client_->DeleteScene("second"), absl::OkStatus());
  EXPECT_EQ(client_->ListScenes()->size(), 1u);
}

TEST_F(StudioTest, ErrorsCarryGoogleRpcDetails) {
  grpc::ClientContext context;
  v1::CreateSceneRequest request;
  request.set_scene_id("no spaces");
  v1::CreateSceneResponse response;
  const auto status = client_->stub().CreateScene(&context, request, &response);
  google::rpc::Status details;
  ASSERT_TRUE(details.ParseFromString(status.error_details()));
  EXPECT_EQ(details.code(), status.error_code());
  google::rpc::ErrorInfo info;
  ASSERT_TRUE(details.details(0).UnpackTo(&info));
  EXPECT_EQ(info.reason(), "BAD_ID");
  google::rpc::BadRequest bad_request;
  ASSERT_TRUE(details.details(1).UnpackTo(&bad_request));
  EXPECT_EQ(bad_request.field_violations(0).field(), "scene_id");
}

std::vector<v1::UploadBlobRequest> BoxUpload() {
  const auto blob = EncodeBlob(BoxMesh()->geometry());
  std::vector<v1::UploadBlobRequest> requests(1);
  requests[0].mutable_header()->set_hash(ToProto(BoxMesh()->id()));
  requests[0].mutable_header()->set_size_bytes(blob.size());
  requests[0].set_data(blob.data(), blob.size());
  return requests;
}

TEST_F(StudioTest, A08BadUploadsAreRefusedAndLeaveNothing) {
  const auto before = client_->ServerInfo().statistics();
  auto wrong_hash = BoxUpload();
  wrong_hash[0].mutable_header()->set_hash(std::string(32, 'h'));
  EXPECT_THAT(client_->Upload(wrong_hash).status(),
              IsRefused(absl::StatusCode::kInvalidArgument, "HASH_MISMATCH", "header.hash"));
  auto changed = BoxUpload();
  (*changed[0].mutable_data())[40] ^= 1;
  EXPECT_EQ(client_->Upload(changed).status().code(), absl::StatusCode::kInvalidArgument);
  auto no_header = BoxUpload();
  no_header[0].clear_header();
  EXPECT_THAT(client_->Upload(no_header).status(),
              IsRefused(absl::StatusCode::kInvalidArgument, "MISSING_FIELD", "header"));
  auto too_long = BoxUpload();
  too_long[0].mutable_header()->set_size_bytes(100);
  EXPECT_THAT(client_->Upload(too_long).status(),
              IsRefused(absl::StatusCode::kInvalidArgument, "LENGTH", "data"));
  auto too_short = BoxUpload();
  too_short[0].mutable_header()->set_size_bytes(1'000'000);
  EXPECT_THAT(client_->Upload(too_short).status(),
              IsRefused(absl::StatusCode::kInvalidArgument, "LENGTH", "data"));
  auto huge = BoxUpload();
  huge[0].mutable_header()->set_size_bytes(~uint64_t{0});
  EXPECT_THAT(client_->Upload(huge).status(), IsRefused(absl::StatusCode::kResourceExhausted,
                                                        "QUOTA_BLOB_BYTES", "header.size_bytes"));
  auto nothing = BoxUpload();
  nothing[0].mutable_header()->set_size_bytes(0);
  EXPECT_THAT(client_->Upload(nothing).status(),
              IsRefused(absl::StatusCode::kInvalidArgument, "LENGTH", "header.size_bytes"));
  const auto after = client_->ServerInfo().statistics();
  EXPECT_EQ(after.blobs(), before.blobs());
  EXPECT_EQ(after.blob_bytes(), before.blob_bytes()) << "reservations are given back";
}

TEST(PenumbraServerTest, A11OneUploadBringsAsManyBlobsAsARequestNames) {
  ServerOptions options;
  options.limits.max_hashes_per_request = 2;
  const auto server = StartServer(options);
  WireClient client(server->address());
  const auto box = BoxUpload()[0];
  EXPECT_EQ(client.Upload({box, box}).status(), absl::OkStatus());
  EXPECT_THAT(client.Upload({box, box, box}).status(),
              IsRefused(absl::StatusCode::kResourceExhausted, "QUOTA_HASHES", "header"));
}

TEST_F(StudioTest, BlobsGoUpOnceAndComeDownTheSame) {
  MeshGeometry geometry = UnitSquareGeometry();
  geometry.indices.insert(geometry.indices.end(), {0, 0, 1});  // a triangle of no area
  const auto square = MeshOf(geometry);
  EXPECT_THAT(client_->FindMissing({ToProto(square->id()), ToProto(BoxMesh()->id())}).value(),
              ::testing::ElementsAre(ToProto(square->id())));
  const auto blob = EncodeBlob(square->geometry());
  std::vector<v1::UploadBlobRequest> requests = BoxUpload();
  requests.emplace_back().mutable_header()->set_hash(ToProto(square->id()));
  requests[1].mutable_header()->set_size_bytes(blob.size());
  for (const std::byte byte : blob) requests.emplace_back().set_data(&byte, 1);
  const auto stored = client_->Upload(requests);
  ASSERT_TRUE(stored.ok()) << stored.status();
  EXPECT_EQ(stored->blobs(0).degenerate_triangle_count(), 0u);
  EXPECT_EQ(stored->blobs(1).degenerate_triangle_count(), 1u);
  EXPECT_TRUE(client_->FindMissing({ToProto(square->id())})->empty());
  const auto back = client_->Download(square->id());
  ASSERT_TRUE(back.ok()) << back.status();
  EXPECT_EQ(*back, std::string(reinterpret_cast<const char*>(blob.data()), blob.size()));
  EXPECT_THAT(client_->Download(ContentHash{}).status(),
              IsRefused(absl::StatusCode::kNotFound, "UNKNOWN_ID", "hash"));
}

TEST_F(StudioTest, A13BadSpecsAreRefusedAndTheSessionGoesOn) {
  for (const uint32_t samples : {0u, 1025u, 0x80000000u}) {
    const auto status = session_->Subscribe(1, FloorSpec(samples), 1);
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << samples << ": " << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr("samples"));
  }
  v1::SessionRequest request;
  request.mutable_subscribe()->mutable_spec()->set_light_id("lamp");
  session_->Send(request);
  const auto response = session_->ReadUntil(v1::SessionResponse::kSubscribeResult);
  EXPECT_THAT(FromProto(response->subscribe_result().error()),
              IsRefused(absl::StatusCode::kInvalidArgument, "UNKNOWN_TECHNIQUE", "spec.technique"));
  EXPECT_EQ(session_->Subscribe(1, FloorSpec(), 4), absl::OkStatus());
  EXPECT_THAT(session_->Subscribe(1, FloorSpec(), 4),
              IsRefused(absl::StatusCode::kAlreadyExists, "DUPLICATE_ID", "subscription_id"));
  session_->AwaitUpdate(1, IsFinal);
}

absl::Status ErrorOf(WireSession& session, const v1::SessionRequest& request) {
  session.Send(request);
  return FromProto(session.ReadUntil(v1::SessionResponse::kSessionError)->session_error().error());
}

TEST_F(StudioTest, B15RequestsOutOfPlaceAreErrorsOfTheSession) {
  EXPECT_THAT(ErrorOf(*session_, {}),
              IsRefused(absl::StatusCode::kInvalidArgument, "MISSING_FIELD", "request"));
  v1::SessionRequest request;
  request.mutable_unsubscribe()->set_subscription_id(99);
  EXPECT_THAT(ErrorOf(*session_, request),
              IsRefused(absl::StatusCode::kNotFound, "UNKNOWN_ID", "subscription_id"));
  request.mutable_credit()->set_subscription_id(99);
  EXPECT_THAT(ErrorOf(*session_, request),
              IsRefused(absl::StatusCode::kNotFound, "UNKNOWN_ID", "subscription_id"));
  request.mutable_hello()->set_scene_id("studio");
  EXPECT_THAT(ErrorOf(*session_, request),
              IsRefused(absl::StatusCode::kFailedPrecondition, "HELLO_REPEATED", "hello"));
  EXPECT_EQ(session_->Commit(MoveBox({0, 1, 1})).revision(), 2u);

  WireSession unopened(client_->stub());
  request.mutable_commit()->set_commit_id(1);
  EXPECT_THAT(ErrorOf(unopened, request),
              IsRefused(absl::StatusCode::kFailedPrecondition, "HELLO_REQUIRED", "request"));
  EXPECT_EQ(unopened.Hello("studio").scene().revision(), 2u);
}

absl::Status RefusedHello(WireClient& client, const std::string& scene_id, uint32_t version) {
  WireSession session(client.stub());
  v1::SessionRequest request;
  request.mutable_hello()->set_scene_id(scene_id);
  request.mutable_hello()->add_protocol_versions(version);
  session.Send(request);
  return session.End();
}

TEST_F(StudioTest, HellosThatCannotBeMetEndTheCall) {
  EXPECT_THAT(RefusedHello(*client_, "ghost", 1),
              IsRefused(absl::StatusCode::kNotFound, "UNKNOWN_ID", "hello.scene_id"));
  EXPECT_THAT(RefusedHello(*client_, std::string(200, 'x'), 1),
              IsRefused(absl::StatusCode::kInvalidArgument, "BAD_ID", "hello.scene_id"));
  EXPECT_THAT(RefusedHello(*client_, "studio", 2), IsRefused(absl::StatusCode::kFailedPrecondition,
                                                             "VERSION", "hello.protocol_versions"));
}

}  // namespace
}  // namespace penumbra::testing
