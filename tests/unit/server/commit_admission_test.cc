#include "server/scene_store/commit_admission.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <string>
#include <vector>

#include "render/scene/field_error.h"
#include "render/scene/retry_delay.h"

namespace penumbra::testing {
namespace {

using ::testing::HasSubstr;
using Clock = StorageBacklog::Clock;

class CommitAdmissionTest : public ::testing::Test {
 protected:
  absl::Status Admit(const std::string& principal, uint64_t bytes, const SceneBacklog& scene = {}) {
    return AdmitCommit({.principal = principal, .bytes = bytes}, scene, all_, limits_, now_);
  }
  void ExpectRefused(const absl::Status& status, const char* reason, const char* text,
                     double delay_ms) {
    EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted) << status;
    EXPECT_EQ(ErrorReason(status), reason) << status;
    EXPECT_EQ(ErrorFieldPath(status), "commit");
    EXPECT_THAT(std::string(status.message()), HasSubstr(text));
    EXPECT_EQ(RetryDelayMs(status), delay_ms) << status;
  }
  // The most that are let in.
  void ExpectRoom(const std::string& principal, uint64_t bytes) {
    EXPECT_EQ(Admit(principal, bytes), absl::OkStatus()) << principal;
    EXPECT_EQ(ErrorReason(Admit(principal, bytes + 1)), "QUOTA_PENDING_BYTES") << principal;
  }

  const ServerLimits limits_{.max_pending_commits = 10,
                             .max_pending_commit_bytes = 400,
                             .max_all_pending_commit_bytes = 1'000,
                             .max_commit_delay_ms = 250,
                             .max_read_delay_ms = 30};
  StorageBacklog all_;
  const Clock::time_point now_{std::chrono::hours(1)};
};

TEST_F(CommitAdmissionTest, WhoeverComesNextFindsHalfOfWhatIsLeft) {
  ExpectRoom("greedy", 500);
  all_.Add("greedy", 500);
  ExpectRefused(Admit("greedy", 1), "QUOTA_PENDING_BYTES",
                "found 501 bytes of commits on their way to the disk with this one, need at most "
                "500 of all scenes of one principal",
                50);
  ExpectRoom("modest", 250);
  all_.Add("modest", 250);
  ExpectRoom("third", 125);
  all_.Add("third", 125);
  ExpectRoom("fourth", 62);
  all_.Remove("modest", 250);
  ExpectRoom("third", 125);  // (1'000 - 500) / 2, of which it has 125
  all_.Remove("greedy", 500);
  all_.Remove("third", 125);
  ExpectRoom("modest", 500);
  EXPECT_EQ(all_.BytesOf("greedy"), 0u);
}

TEST_F(CommitAdmissionTest, EmptyCommitsTakeNoRoom) {
  for (const uint64_t bytes : {0, 500, 0}) all_.Add("ana", bytes);
  EXPECT_EQ(Admit("ana", 0), absl::OkStatus());
  for (const uint64_t bytes : {500, 0, 0}) all_.Remove("ana", bytes);
  ExpectRoom("ana", 500);
}

TEST_F(CommitAdmissionTest, WhatCameAtTheSameMomentMayPassTheLimitAndLeavesNothing) {
  all_.Add("one", 800);
  all_.Add("another", 300);
  EXPECT_EQ(ErrorReason(Admit("third", 1)), "QUOTA_PENDING_BYTES");
  all_.Remove("one", 800);
  ExpectRoom("third", 350);
}

CommitSender Sender(double of_mean, size_t sessions = 200, bool has_unanswered = true) {
  return {.share = {.of_mean = of_mean, .sessions = sessions}, .has_unanswered = has_unanswered};
}
const CommitSender kOneOfMany = Sender(1);

TEST_F(CommitAdmissionTest, TheLongerRequestsWaitToBeReadTheMoreAreRefused) {
  const auto refused_of_1000 = [&](double waited_ms, const CommitSender& sender = kOneOfMany) {
    const auto waited = std::chrono::duration_cast<Clock::duration>(
        std::chrono::duration<double, std::milli>(waited_ms));
    int refused = 0;
    for (int i = 0; i < 1'000; ++i)
      refused += !AdmitByReadDelay(waited, i / 1e3, sender, limits_).ok();
    return refused;
  };
  EXPECT_EQ(refused_of_1000(0), 0);
  EXPECT_EQ(refused_of_1000(3), 0);
  EXPECT_NEAR(refused_of_1000(16.5), 500, 1);
  EXPECT_EQ(refused_of_1000(30), 950);
  EXPECT_EQ(refused_of_1000(2'000), 950) << "whoever comes again and again is let in";
  EXPECT_EQ(refused_of_1000(30, Sender(5)), 950);
  EXPECT_EQ(refused_of_1000(30, Sender(0.5)), 950) << "those who wait send by fits and starts";
  EXPECT_NEAR(refused_of_1000(30, Sender(0.05)), 95, 1) << "it is not they who send so much";
  EXPECT_NEAR(refused_of_1000(16.5, Sender(0.05)), 50, 1);
  EXPECT_EQ(refused_of_1000(30, Sender(0)), 0);
}

// No more than there are of them wait.
TEST_F(CommitAdmissionTest, OfFewWhoWaitForAnswersNoneIsRefusedForLong) {
  const auto refused = [&](double limits, const CommitSender& sender) {
    const auto waited = std::chrono::duration_cast<Clock::duration>(
        limits * std::chrono::milliseconds(limits_.max_read_delay_ms));
    return !AdmitByReadDelay(waited, 0.4, sender, limits_).ok();
  };
  const CommitSender one_of_few = Sender(1, 64, false);
  EXPECT_FALSE(refused(4, one_of_few));
  EXPECT_TRUE(refused(6, one_of_few));
  EXPECT_TRUE(refused(1, Sender(1, 65, false))) << "of many";
  EXPECT_TRUE(refused(1, Sender(1, 64, true))) << "who does not wait";
}

TEST_F(CommitAdmissionTest, HowLongRequestsWaitNeedNotMatter) {
  const ServerLimits limits{.max_read_delay_ms = 0};
  EXPECT_EQ(AdmitByReadDelay(std::chrono::seconds(10), 0, kOneOfMany, limits), absl::OkStatus());
}

TEST_F(CommitAdmissionTest, ThoseWhoAreRefusedTogetherDoNotComeBackTogether) {
  for (const auto waited : {std::chrono::milliseconds(15), std::chrono::milliseconds(60)}) {
    std::vector<double> delays_ms;
    for (int i = 0; i < 1'000; ++i) {
      const absl::Status status = AdmitByReadDelay(waited, i / 1e3, kOneOfMany, limits_);
      if (!status.ok()) delays_ms.push_back(RetryDelayMs(status).value());
    }
    ASSERT_GT(delays_ms.size(), 100u);
    std::ranges::sort(delays_ms);
    for (size_t i = 0; i < delays_ms.size(); ++i) {
      EXPECT_NEAR(delays_ms[i], 200 + 400.0 * i / delays_ms.size(), 5);
    }
  }
  ExpectRefused(AdmitByReadDelay(std::chrono::milliseconds(31), 0, kOneOfMany, limits_),
                "OVERLOADED", "found requests read 31 ms after they came, need at most 30", 200);
}

TEST_F(CommitAdmissionTest, AScenesCommitsAreBoundedWhoeverTheyAreOf) {
  const SceneBacklog scene{.commits = 9, .bytes = 390, .oldest_came = now_};
  EXPECT_EQ(Admit("ana", 10, scene), absl::OkStatus());
  ExpectRefused(Admit("ana", 11, scene), "QUOTA_PENDING_BYTES", "at most 400 of one scene", 50);
  const SceneBacklog many{
      .commits = 10, .bytes = 10, .oldest_came = now_ - std::chrono::milliseconds(120)};
  ExpectRefused(Admit("ana", 1, many), "QUOTA_PENDING", "fewer than 10 of one scene", 120);
}

TEST_F(CommitAdmissionTest, WhatIsBehindForTooLongIsToldHowLongToWait) {
  all_.OnPosted(WrittenTo::kFile, now_ - std::chrono::milliseconds(250));
  EXPECT_EQ(Admit("ana", 1), absl::OkStatus());
  all_.OnTaken(WrittenTo::kFile);
  all_.OnPosted(WrittenTo::kFile, now_ - std::chrono::milliseconds(300));
  // What goes to the journal is no sign that files are written.
  all_.OnPosted(WrittenTo::kJournal, now_);
  all_.OnTaken(WrittenTo::kJournal);
  ExpectRefused(Admit("ana", 1), "OVERLOADED", "300 ms behind", 300);
  const SceneBacklog slow{.commits = 1, .bytes = 1, .oldest_came = now_ - std::chrono::minutes(1)};
  ExpectRefused(Admit("ana", 1, slow), "OVERLOADED", "60000 ms behind", 5'000);
}

}  // namespace
}  // namespace penumbra::testing
