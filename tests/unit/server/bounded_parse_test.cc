#include "server/session/bounded_parse.h"

#include <gtest/gtest.h>

#include <algorithm>
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

// The shortest ids that there are.
std::string ShortId(uint32_t number) {
  constexpr char kLetters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-";
  std::string id;
  for (++number; number > 0; number = (number - 1) / 64) id += kLetters[(number - 1) % 64];
  return id;
}

// A field of bytes as it stands on the wire.
std::string Field(int number, const std::string& content) {
  std::string field(1, static_cast<char>(number << 3 | 2));
  size_t length = content.size();
  for (; length > 127; length >>= 7) field += static_cast<char>(length | 128);
  return field + static_cast<char>(length) + content;
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
    emptied.mutable_commit()->mutable_delta()->add_remove_instances(ShortId(i));
  }
  v1::SessionRequest request;
  EXPECT_EQ(Parse(emptied.SerializeAsString(), request), absl::OkStatus());
}

TEST(BoundedParseTest, B15UnknownFieldsPassAndCount) {
  v1::SessionRequest request;
  EXPECT_EQ(Parse("\x78\x05", request), absl::OkStatus());  // field 15, varint
  std::string many;
  for (int i = 0; i < 100'000; ++i) many += std::string("\x7a\x00", 2);  // field 15, empty
  EXPECT_EQ(ErrorReason(Parse(many, request)), "QUOTA_ELEMENTS");
}

TEST(BoundedParseTest, B15NothingIsKeptOfUnknownFields) {
  v1::SessionRequest known;
  known.mutable_presence()->set_display_name("Ada");
  known.mutable_presence()->mutable_camera()->set_fov_y_deg(30);
  known.mutable_presence()->add_selected_ids("box");
  const std::string secret(1'000, 's');
  std::string presence = known.presence().SerializeAsString();
  presence += Field(15, secret);                                   // no such field
  presence += Field(v1::Presence::kColourRgbFieldNumber, secret);  // a number's, as bytes
  presence += Field(v1::Presence::kCameraFieldNumber, Field(15, secret));
  const std::string bytes =
      Field(v1::SessionRequest::kPresenceFieldNumber, presence) + Field(15, secret);
  v1::SessionRequest kept;
  ASSERT_TRUE(kept.ParseFromString(bytes));
  ASSERT_GT(kept.ByteSizeLong(), 4'000u) << "which protobuf itself keeps";
  v1::SessionRequest request;
  ASSERT_EQ(Parse(bytes, request), absl::OkStatus());
  EXPECT_EQ(request.SerializeAsString(), known.SerializeAsString());
}

TEST(BoundedParseTest, B16EmptyMessagesByTheThousandAreRefusedUnparsed) {
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

// A commit of `count` times `element`, filled up to about `bytes` with a long key.
std::string CommitOf(const std::string& element, size_t count, size_t bytes) {
  std::string delta;
  for (size_t i = 0; i < count; ++i) delta += element;
  const size_t rest = bytes - std::min(bytes, delta.size() + 16);
  return Field(v1::SessionRequest::kCommitFieldNumber,
               Field(v1::Commit::kDeltaFieldNumber, delta) +
                   Field(v1::Commit::kIdempotencyKeyFieldNumber, std::string(rest, 'k')));
}

// The most of `element` that is let through in a message of about `bytes`.
v1::SessionRequest MostThatPasses(const std::string& element, size_t bytes) {
  size_t passes = 0, fails = (bytes - 16) / element.size();
  v1::SessionRequest parsed;
  while (passes + 1 + passes / 100 < fails) {
    const size_t count = (passes + fails) / 2;
    (Parse(CommitOf(element, count, bytes), parsed).ok() ? passes : fails) = count;
  }
  EXPECT_GT(passes, 1000u);
  EXPECT_EQ(Parse(CommitOf(element, passes, bytes), parsed), absl::OkStatus());
  return parsed;
}

TEST(BoundedParseTest, B16WhatPassesTakesNotMuchMoreThanItsBytes) {
  const std::string kElements[] = {
      std::string("\x12\x00", 2),                  // an empty instance
      std::string("\x1a\x00", 2),                  // an empty id
      std::string("\x22\x00", 2),                  // an empty light
      std::string("\x32\x00", 2),                  // an empty receiver
      std::string("\x12\x04\x0a\x00\x12\x00", 6),  // an instance with two empty strings
      std::string("\x22\x04\x12\x02\x0a\x00", 6),  // a light with a shape with a corner
      std::string("\x7a\x00", 2),                  // an unknown field
  };
  for (const std::string& element : kElements) {
    for (const size_t bytes : {32u << 10, 512u << 10}) {
      const auto request = MostThatPasses(element, bytes);
      EXPECT_LE(request.SpaceUsedLong(), std::max<size_t>(20 * bytes, 2 << 20))
          << bytes << " bytes of " << ::testing::PrintToString(element);
    }
  }
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
