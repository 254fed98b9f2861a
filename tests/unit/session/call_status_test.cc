#include "client/session/call_status.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "proto/convert/status_convert.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

using ::testing::HasSubstr;

constexpr char kAddress[] = "lamp.example:7717";

TEST(CallStatusTest, AnErrorOfTheServersKeepsItsCodeReasonAndField) {
  const absl::Status made =
      FieldError(absl::StatusCode::kNotFound, "UNKNOWN_ID", "scene_id", "found \"x\"");
  const absl::Status seen = StatusOfCall(kAddress, ToGrpcStatus(made));
  EXPECT_EQ(seen.code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(ErrorReason(seen), "UNKNOWN_ID");
  EXPECT_EQ(ErrorFieldPath(seen), "scene_id");
  EXPECT_EQ(seen.message(), made.message());
}

TEST(CallStatusTest, ErrorsOfTheTransportAreUnavailableAndNameTheAddress) {
  for (const auto code : {grpc::StatusCode::UNAVAILABLE, grpc::StatusCode::DEADLINE_EXCEEDED,
                          grpc::StatusCode::UNKNOWN, grpc::StatusCode::UNIMPLEMENTED}) {
    const absl::Status seen = StatusOfCall(kAddress, grpc::Status(code, "Connection refused"));
    EXPECT_EQ(seen.code(), absl::StatusCode::kUnavailable) << code;
    EXPECT_THAT(std::string(seen.message()), HasSubstr(kAddress)) << code;
  }
}

TEST(CallStatusTest, ASessionThatEndsUnaskedIsNeverOk) {
  for (const auto& status : {grpc::Status::OK, grpc::Status(grpc::StatusCode::CANCELLED, "x"),
                             grpc::Status(grpc::StatusCode::UNAVAILABLE, "Socket closed"),
                             grpc::Status(grpc::StatusCode::UNKNOWN, "Stream removed")}) {
    const absl::Status seen = StatusOfEndedSession(kAddress, status);
    EXPECT_EQ(seen.code(), absl::StatusCode::kUnavailable) << status.error_message();
    EXPECT_THAT(std::string(seen.message()), HasSubstr("the server has gone away"));
  }
  const absl::Status refused = StatusOfEndedSession(
      kAddress, ToGrpcStatus(FieldError(absl::StatusCode::kFailedPrecondition, "VERSION",
                                        "hello.protocol_versions", "found 9")));
  EXPECT_EQ(refused.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(ErrorReason(refused), "VERSION");
}

}  // namespace
}  // namespace penumbra
