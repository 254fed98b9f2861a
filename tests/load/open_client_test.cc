#include "tests/load/open_client.h"

#include <gtest/gtest.h>

#include "tests/support/hostile_server.h"
#include "tests/support/shapes.h"

namespace penumbra::load {
namespace {

// The calls end while commits are being sent, at any moment.
TEST(OpenClientTest, WhatIsSentToAServerThatEndsTheCallIsNotAnswered) {
  testing::HostileServer server([](testing::HostileServer::Stream& stream, int session) {
    v1::SessionRequest request;
    for (int i = 0; i < session; ++i) stream.Read(&request);
    return grpc::Status(grpc::StatusCode::INTERNAL, "enough");
  });
  const Instance box{.id = "box", .mesh = testing::MeshOf(testing::UnitBoxGeometry())};
  for (int session = 1; session <= 40; ++session) {
    OpenClient client(server.address(), "load0", box, /*is_deaf=*/true);
    ASSERT_EQ(client.Open(), absl::OkStatus());
    constexpr int kCommits = 200;
    for (int i = 0; i < kCommits; ++i) client.Commit(Clock::now());
    client.AwaitAnswers(Clock::now() + std::chrono::seconds(20));
    EXPECT_EQ(client.status().code(), absl::StatusCode::kInternal) << client.status();
    const auto records = client.TakeRecords();
    ASSERT_EQ(records.size(), size_t{kCommits});
    for (const CommitRecord& record : records) {
      ASSERT_EQ(record.fate, CommitRecord::Fate::kUnanswered);
    }
  }
}

}  // namespace
}  // namespace penumbra::load
