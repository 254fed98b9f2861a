#include "proto/convert/status_convert.h"

#include <gtest/gtest.h>

#include <string>

#include "google/rpc/error_details.pb.h"
#include "render/scene/field_error.h"
#include "render/scene/retry_delay.h"

namespace penumbra {
namespace {

void ExpectSame(const absl::Status& found, const absl::Status& expected) {
  EXPECT_EQ(found.code(), expected.code());
  EXPECT_EQ(found.message(), expected.message());
  EXPECT_EQ(ErrorReason(found), ErrorReason(expected));
  EXPECT_EQ(ErrorFieldPath(found), ErrorFieldPath(expected));
}

TEST(StatusConvertTest, EveryCodeGoesThereAndBack) {
  for (int code = 1; code <= 16; ++code) {
    const auto kind = static_cast<absl::StatusCode>(code);
    for (const absl::Status& status :
         {absl::Status(kind, "plain"), absl::Status(kind, ""),
          FieldError(kind, "RANGE", "", "found 0, need more"),
          FieldError(kind, "RANGE", "lights[2].edge_v", "found 0, need more"),
          WithFieldPrefix(FieldError(kind, "BAD_ID", "id", "found ''"), "hello.")}) {
      ExpectSame(FromProto(ToProto(status)), status);
      ExpectSame(FromGrpcStatus(ToGrpcStatus(status)), status);
      EXPECT_EQ(static_cast<int>(ToGrpcStatus(status).error_code()), code);
    }
  }
  EXPECT_TRUE(FromProto(ToProto(absl::OkStatus())).ok());
  EXPECT_TRUE(ToGrpcStatus(absl::OkStatus()).ok());
  EXPECT_TRUE(FromGrpcStatus(grpc::Status::OK).ok());
}

TEST(StatusConvertTest, AFieldPrefixIsTakenOffAsItWasPutOn) {
  const absl::Status bare = FieldError(absl::StatusCode::kNotFound, "UNKNOWN_ID", "id", "found x");
  ExpectSame(WithoutFieldPrefix(WithFieldPrefix(bare, "hello."), "hello."), bare);
  ExpectSame(WithoutFieldPrefix(bare, "hello."), bare);
  ExpectSame(WithoutFieldPrefix(absl::AbortedError("hello.id"), "hello."),
             absl::AbortedError("hello.id"));
}

TEST(StatusConvertTest, DetailsAreThoseOfGoogleRpc) {
  const auto proto =
      ToProto(FieldError(absl::StatusCode::kInvalidArgument, "NON_FINITE", "a[1].b", "found NaN"));
  EXPECT_EQ(proto.code(), 3);
  EXPECT_EQ(proto.message(), "a[1].b: found NaN");
  EXPECT_EQ(proto.details(0).type_url(), "type.googleapis.com/google.rpc.ErrorInfo");
  EXPECT_EQ(proto.details(1).type_url(), "type.googleapis.com/google.rpc.BadRequest");
  google::rpc::BadRequest request;
  ASSERT_TRUE(proto.details(1).UnpackTo(&request));
  EXPECT_EQ(request.field_violations(0).field(), "a[1].b");
  EXPECT_EQ(request.field_violations(0).description(), "found NaN");
}

TEST(StatusConvertTest, WhereThereAreNoDetailsTheReasonIsInTheMessage) {
  const auto kCode = grpc::StatusCode::RESOURCE_EXHAUSTED;
  const absl::Status slow =
      FieldError(absl::StatusCode::kResourceExhausted, "SLOW_CONSUMER", "", "found nothing taken");
  const std::string message = MessageWithReason(slow);
  EXPECT_EQ(message, "[SLOW_CONSUMER] found nothing taken");
  ExpectSame(FromGrpcStatus(grpc::Status(kCode, message)), slow);
  EXPECT_EQ(MessageWithReason(absl::UnavailableError("gone")), "gone");
  for (const char* plain : {"", "[", "[]", "[] x", "[X]", "[X]x", "[x] y", "X] y", "[X Y] z",
                            "Received message larger than max (5 vs. 4)"}) {
    ExpectSame(FromGrpcStatus(grpc::Status(kCode, plain)), absl::ResourceExhaustedError(plain));
  }
}

TEST(StatusConvertTest, ARetryDelayTravelsAsRetryInfo) {
  const absl::Status plain = absl::UnavailableError("later");
  const absl::Status field =
      FieldError(absl::StatusCode::kResourceExhausted, "OVERLOADED", "commit", "found too many");
  for (const absl::Status& status : {plain, field}) {
    const absl::Status delayed = WithRetryDelay(status, 2'250);
    ExpectSame(delayed, status);
    for (const absl::Status& there :
         {FromProto(ToProto(delayed)), FromGrpcStatus(ToGrpcStatus(delayed)),
          FromProto(ToProto(WithFieldPrefix(delayed, "hello.")))}) {
      EXPECT_EQ(RetryDelayMs(there).value_or(-1), 2'250);
      EXPECT_EQ(ErrorReason(there), ErrorReason(status));
    }
    EXPECT_FALSE(RetryDelayMs(FromProto(ToProto(status))));
  }
  const auto proto = ToProto(WithRetryDelay(field, 2'250.2));
  google::rpc::RetryInfo info;
  ASSERT_TRUE(proto.details(2).UnpackTo(&info));
  EXPECT_EQ(info.retry_delay().seconds(), 2);
  EXPECT_EQ(info.retry_delay().nanos(), 251'000'000) << "never shorter";
  info.mutable_retry_delay()->set_seconds(-5);
  google::rpc::Status negative = proto;
  negative.mutable_details(2)->PackFrom(info);
  EXPECT_EQ(RetryDelayMs(FromProto(negative)).value_or(-1), 0);
  for (const int64_t seconds : {int64_t{3'601}, INT64_MAX}) {
    info.mutable_retry_delay()->set_seconds(seconds);
    negative.mutable_details(2)->PackFrom(info);
    EXPECT_EQ(RetryDelayMs(FromProto(negative)).value_or(-1), 3'600'000);
  }
}

TEST(StatusConvertTest, ForeignErrorsKeepCodeAndMessage) {
  ExpectSame(FromGrpcStatus(grpc::Status(grpc::StatusCode::UNAVAILABLE, "failed to connect")),
             absl::UnavailableError("failed to connect"));
  ExpectSame(FromGrpcStatus(grpc::Status(grpc::StatusCode::ABORTED, "m", "not a message \xff")),
             absl::AbortedError("m"));
  google::rpc::Status other;
  other.set_code(static_cast<int>(absl::StatusCode::kNotFound));
  other.set_message("m");
  google::rpc::ErrorInfo info;
  info.set_reason("THEIRS");
  info.set_domain("example.org");
  other.add_details()->PackFrom(info);
  ExpectSame(FromProto(other), absl::NotFoundError("m"));
  other.set_code(1234);
  EXPECT_EQ(FromProto(other).code(), absl::StatusCode::kUnknown);
}

}  // namespace
}  // namespace penumbra
