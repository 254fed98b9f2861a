#include "server/session/bounded_parse.h"

#include <gtest/gtest.h>

#include <string>

#include "penumbra/v1/session.pb.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

absl::Status Parse(const std::string& bytes, v1::SessionRequest& request,
                   const ServerLimits& limits = {}) {
  return ParseBounded(std::span(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()),
                      limits, request);
}

v1::SessionRequest LargeHonestCommit() {
  v1::SessionRequest request;
  auto& delta = *request.mutable_commit()->mutable_delta();
  for (int i = 0; i < 7000; ++i) {
    auto& instance = *delta.add_upsert_instances();
    instance.set_id("instance" + std::to_string(i));
    instance.set_mesh_hash(std::string(32, 'h'));
    for (int k = 0; k < 12; ++k) instance.add_world_from_mesh(static_cast<float>(k));
    instance.mutable_color()->set_x(0.5f);
    instance.set_casts(true);
  }
  return request;
}

TEST(BoundedParseTest, HonestMessagesPass) {
  const v1::SessionRequest large = LargeHonestCommit();
  ASSERT_GT(large.ByteSizeLong(), 700'000u);
  v1::SessionRequest request;
  ASSERT_EQ(Parse(large.SerializeAsString(), request), absl::OkStatus());
  EXPECT_EQ(request.SerializeAsString(), large.SerializeAsString());
  EXPECT_EQ(Parse("", request), absl::OkStatus());
  EXPECT_EQ(request.request_case(), v1::SessionRequest::REQUEST_NOT_SET);
}

TEST(BoundedParseTest, AFullSceneMayBeEmptiedAtOnce) {
  v1::SessionRequest emptied;
  for (uint32_t i = 0; i < SceneLimits().max_instances; ++i) {
    emptied.mutable_commit()->mutable_delta()->add_remove_instances(std::to_string(i));
  }
  v1::SessionRequest request;
  EXPECT_EQ(Parse(emptied.SerializeAsString(), request), absl::OkStatus());
}

TEST(BoundedParseTest, UnknownFieldsPassAndCount) {
  v1::SessionRequest request;
  EXPECT_EQ(Parse("\x78\x05", request), absl::OkStatus());  // field 15, varint
  std::string many;
  for (int i = 0; i < 100'000; ++i) many += std::string("\x7a\x00", 2);  // field 15, empty
  EXPECT_EQ(ErrorReason(Parse(many, request)), "QUOTA_ELEMENTS");
}

TEST(BoundedParseTest, EmptyMessagesByTheThousandAreRefusedUnparsed) {
  std::string instances;
  for (int i = 0; i < 80'000; ++i) instances += std::string("\x12\x00", 2);
  v1::SessionRequest outer;
  ASSERT_TRUE(outer.mutable_commit()->mutable_delta()->ParseFromString(instances));
  v1::SessionRequest request;
  const auto status = Parse(outer.SerializeAsString(), request);
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(ErrorReason(status), "QUOTA_ELEMENTS");
  EXPECT_EQ(request.request_case(), v1::SessionRequest::REQUEST_NOT_SET);
}

TEST(BoundedParseTest, TooLongAndMalformedAreTold) {
  v1::SessionRequest request;
  ServerLimits limits;
  limits.max_message_bytes = 10;
  EXPECT_EQ(ErrorReason(Parse(std::string(11, 'x'), request, limits)), "QUOTA_MESSAGE_BYTES");
  for (const std::string& bad : {std::string("\x12\x05"
                                             "abc"),                  // shorter than it says
                                 std::string("\x13\x14", 2),          // a group
                                 std::string("\x00", 1),              // field 0
                                 std::string("\x12\x02\x12\x05", 4),  // inside out
                                 std::string("\xff\xff\xff\xff\xff\xff\xff\xff\xff\xff\x01")}) {
    EXPECT_EQ(ErrorReason(Parse(bad, request)), "MALFORMED");
  }
}

}  // namespace
}  // namespace penumbra
