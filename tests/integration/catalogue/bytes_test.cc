// Rows A11, B15 to B17, C15 and A22: bytes that no client of ours sends.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <string>

#include "proto/convert/light_convert.h"
#include "proto/convert/scene_convert.h"
#include "tests/integration/catalogue/catalogue_test.h"
#include "tests/integration/service/raw_session.h"

namespace penumbra::testing {
namespace {

constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;
constexpr auto kExhausted = absl::StatusCode::kResourceExhausted;
constexpr int kCommit = v1::SessionRequest::kCommitFieldNumber;
constexpr int kDelta = v1::Commit::kDeltaFieldNumber;

class ByteRowsTest : public CatalogueTest {
 protected:
  void SetUp() override {
    CatalogueTest::SetUp();
    raw_ = std::make_unique<RawSession>(*client_);
    EXPECT_EQ(raw_->Ask(HelloBytes()).welcome().protocol_version(), 1u);
  }
  void ExpectSessionError(const std::string& bytes, const Refusal& refusal) {
    ExpectRefused([&] { return raw_->Error(bytes); }, refusal);
  }
  void ExpectCommitError(const std::string& bytes, const Refusal& refusal) {
    ExpectRefused([&] { return FromProto(raw_->Ask(bytes).commit_result().error()); }, refusal);
  }
  // The stream on which all of that came takes a commit.
  void TearDown() override {
    v1::SessionRequest commit;
    *commit.mutable_commit()->mutable_delta() = ToProto(MoveBox({0.2f, 1, 0.2f}));
    if (raw_) {
      EXPECT_FALSE(raw_->Ask(commit.SerializeAsString()).commit_result().has_error());
    }
    CatalogueTest::TearDown();
  }
  static std::string Repeated(const std::string& element, size_t bytes) {
    std::string all;
    all.reserve(bytes);
    while (all.size() + element.size() <= bytes) all += element;
    return all;
  }

  std::unique_ptr<RawSession> raw_;
};

uint64_t PeakBytes() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmHWM:")) return std::stoull(line.substr(6)) * 1024;
  }
  return 0;
}

TEST_F(ByteRowsTest, A11AMillionEmptyLightsAreRefusedUnread) {
  const std::string light = Field(v1::SceneDelta::kUpsertLightsFieldNumber, "");
  ExpectSessionError(Field(kCommit, Field(kDelta, Repeated(light, 2'000'000))),
                     {kExhausted, "QUOTA_MESSAGE_BYTES", "request"});
  ExpectSessionError(Field(kCommit, Field(kDelta, Repeated(light, 1'000'000))),
                     {kExhausted, "QUOTA_ELEMENTS", "request"});
}

TEST_F(ByteRowsTest, B15WhatALaterProtocolAddsIsIgnored) {
  v1::SessionRequest commit;
  *commit.mutable_commit()->mutable_delta() = ToProto(MoveBox({1, 1, 1}));
  // In the request, in the delta, and as a number.
  const std::string known = commit.SerializeAsString();
  const auto answer = raw_->Ask(known + Field(15, "news")).commit_result();
  EXPECT_FALSE(answer.has_error()) << answer.error().message();
  const std::string inside = commit.commit().delta().SerializeAsString() +
                             Field(15, Field(1, "news")) + std::string("\x70\x05", 2);
  const auto same = raw_->Ask(Field(kCommit, Field(kDelta, inside))).commit_result();
  EXPECT_FALSE(same.has_error()) << same.error().message();
  EXPECT_EQ(same.content_hash(), answer.content_hash()) << "unknown fields are not kept";
}

TEST_F(ByteRowsTest, B15KindsThatNobodyKnowsAreRefused) {
  ExpectSessionError("", {kInvalid, "MISSING_FIELD", "request"});
  ExpectSessionError(Field(14, "a request of a later protocol"),
                     {kInvalid, "MISSING_FIELD", "request"});
  // A light of a shape with another number.
  ExpectCommitError(Field(kCommit, Field(kDelta, Field(v1::SceneDelta::kUpsertLightsFieldNumber,
                                                       Field(1, "lamp") + Field(15, "")))),
                    {kInvalid, "MISSING_FIELD", "upsert_lights[0].shape"});
  // A method of shading that has no name yet.
  v1::SessionRequest subscribe;
  auto& soft = *subscribe.mutable_subscribe()->mutable_spec()->mutable_soft_texture();
  soft.set_method(static_cast<v1::VisibilityMethod>(99));
  subscribe.mutable_subscribe()->mutable_spec()->set_light_id("lamp");
  subscribe.mutable_subscribe()->mutable_spec()->set_receiver_id("floor");
  const auto status =
      FromProto(raw_->Ask(subscribe.SerializeAsString()).subscribe_result().error());
  EXPECT_EQ(status.code(), kInvalid) << status;
  EXPECT_EQ(ErrorFieldPath(status), "spec.soft_texture.method") << status;
}

TEST_F(ByteRowsTest, B15BytesThatAreNoMessageAreRefused) {
  for (const std::string& bytes :
       {std::string("\xff\xff\xff"),
        std::string("\x12\x05"
                    "abc"),
        std::string("\x13\x14", 2), std::string("\x00", 1),
        Field(kCommit, Field(3, "\xff\xfe"))}) {  // a key that is not UTF-8
    ExpectSessionError(bytes, {kInvalid, "MALFORMED", "request"});
  }
}

// What is refused takes no memory to speak of: parsed, the largest would take 400 MB.
TEST_F(ByteRowsTest, B16FourMegabytesOfNothingAreRefusedUnparsed) {
  const std::string instance = Field(v1::SceneDelta::kUpsertInstancesFieldNumber, "");
  const std::string id = Field(v1::SceneDelta::kRemoveLightsFieldNumber, "");
  const std::string unknown = Field(15, "");
  [[maybe_unused]] const uint64_t before = PeakBytes();
  for (const std::string& element : {instance, id, unknown}) {
    ExpectSessionError(Field(kCommit, Field(kDelta, Repeated(element, (4u << 20) - 64))),
                       {kExhausted, "QUOTA_MESSAGE_BYTES", "request"});
    ExpectSessionError(Field(kCommit, Field(kDelta, Repeated(element, (1u << 20) - 64))),
                       {kExhausted, "QUOTA_ELEMENTS", "request"});
  }
#ifndef __SANITIZE_ADDRESS__  // which keeps what has been freed
  EXPECT_LT(PeakBytes() - before, 80u << 20) << "20 times 4 MiB, the client's own included";
#endif
}

TEST_F(ByteRowsTest, B17NestingWithoutEndIsRefused) {
  const std::string start = Field(kCommit, Field(kDelta, ""));
  for (const size_t depth : {99u, 101u, 200u, 10'000u}) {
    std::string nested = "x";
    for (size_t i = 0; i < depth && nested.size() < 900'000; ++i) {
      nested = Field(v1::SceneDelta::kUpsertInstancesFieldNumber, nested);
    }
    // Instances have no instances: the first is malformed inside, or holds what nobody knows.
    const auto answer = raw_->Ask(Field(kCommit, Field(kDelta, nested)));
    EXPECT_TRUE(answer.has_session_error() || answer.commit_result().has_error()) << depth;
  }
  // Groups nest too, and are none of ours.
  for (const size_t depth : {99u, 101u, 400'000u}) {
    const std::string groups(depth, '\x7b');
    ExpectSessionError(groups + std::string(depth, '\x7c'), {kInvalid, "MALFORMED", "request"});
    ExpectSessionError(groups, {kInvalid, "MALFORMED", "request"});
  }
}

TEST_F(ByteRowsTest, C15AMessageOverTheLimitIsRefusedAndTheSessionLives) {
  for (const size_t size : {size_t{(1u << 20) + 1}, size_t{2u << 20}, size_t{(4u << 20) - 1}}) {
    ExpectSessionError(std::string(size, '\x08'), {kExhausted, "QUOTA_MESSAGE_BYTES", "request"});
  }
  // Past what the transport takes in, the call that brought it ends, and it alone.
  RawSession other(*client_);
  other.Ask(HelloBytes());
  other.Send(std::string((4u << 20) + 1, '\x08'));
  EXPECT_EQ(other.End().code(), kExhausted);
}

}  // namespace
}  // namespace penumbra::testing
