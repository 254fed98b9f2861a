#include "server/quota/principal_quotas.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <fstream>
#include <future>
#include <string>

#include "render/scene/field_error.h"
#include "render/scene/retry_delay.h"
#include "server/quota/quota_options.h"
#include "server/scene_store/scene_owners.h"
#include "tests/support/stalled_file.h"
#include "tests/support/temporary_folder.h"

namespace penumbra::testing {
namespace {

using namespace std::chrono_literals;

class PrincipalQuotasTest : public ::testing::Test {
 protected:
  PrincipalQuotas Quotas(double compute_s_per_minute) {
    return PrincipalQuotas({.each = {.compute_s_per_minute = compute_s_per_minute}},
                           [this] { return now_; });
  }
  void Pass(double seconds) {
    now_ += std::chrono::duration_cast<std::chrono::nanoseconds>(
        std::chrono::duration<double>(seconds));
  }

  std::chrono::steady_clock::time_point now_{std::chrono::hours(1)};
};

TEST_F(PrincipalQuotasTest, AMinutesComputingIsInHandAndComesBackOverAMinute) {
  PrincipalQuotas quotas = Quotas(30);
  EXPECT_FALSE(quotas.StandingOf("ana").gives_way);
  quotas.Charge("ana", 29'999);
  EXPECT_FALSE(quotas.StandingOf("ana").gives_way);
  quotas.Charge("ana", 6'001);  // of a job that began while there was some
  EXPECT_TRUE(quotas.StandingOf("ana").gives_way);
  EXPECT_FALSE(quotas.StandingOf("ben").gives_way) << "others have their own";
  Pass(11.9);
  EXPECT_TRUE(quotas.StandingOf("ana").gives_way) << "6 s are back in 12";
  Pass(0.2);
  EXPECT_FALSE(quotas.StandingOf("ana").gives_way);
  Pass(3'600);
  quotas.Charge("ana", 30'001);
  EXPECT_TRUE(quotas.StandingOf("ana").gives_way) << "more than a minute's is never in hand";
}

TEST_F(PrincipalQuotasTest, WhoIsOverIsToldHowMuchAndForHowLong) {
  PrincipalQuotas quotas = Quotas(30);
  EXPECT_EQ(quotas.CheckCompute("ana"), absl::OkStatus());
  quotas.Charge("ana", 36'000);
  const absl::Status over = quotas.CheckCompute("ana");
  EXPECT_EQ(over.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(ErrorReason(over), "QUOTA_COMPUTE");
  EXPECT_NE(over.message().find("found 36 s of computing, need at most 30 a minute"),
            absl::string_view::npos)
      << over;
  EXPECT_NEAR(RetryDelayMs(over).value_or(0), 12'000, 1);
  Pass(12.1);
  EXPECT_EQ(quotas.CheckCompute("ana"), absl::OkStatus());
}

TEST_F(PrincipalQuotasTest, WithoutAQuotaNothingIsCounted) {
  PrincipalQuotas quotas = Quotas(0);
  quotas.Charge("ana", 1e9);
  EXPECT_FALSE(quotas.StandingOf("ana").gives_way);
  EXPECT_EQ(quotas.CheckCompute("ana"), absl::OkStatus());
}

TEST(QuotaOptionsTest, ANameHasItsOwnWithTheRestOfEverybodys) {
  const QuotaSettings settings{.each = {.scenes = 20, .compute_s_per_minute = 30},
                               .named = {"farm:scenes=0,blob-bytes=2G,weight=0.5",
                                         "cn:render-01:compute=600;ana:sessions=3"}};
  const auto options = ToOptions(settings, /*everyone_is_known=*/true);
  ASSERT_TRUE(options.ok()) << options.status();
  const PrincipalQuotas quotas(*options);
  EXPECT_EQ(quotas.Of("somebody").scenes, 20u);
  EXPECT_EQ(quotas.Of("farm").scenes, 0u);
  EXPECT_EQ(quotas.Of("farm").blob_bytes, uint64_t{2} << 30);
  EXPECT_EQ(quotas.Of("farm").weight, 0.5);
  EXPECT_EQ(quotas.Of("farm").compute_s_per_minute, 30);
  EXPECT_EQ(quotas.Of("cn:render-01").compute_s_per_minute, 600);
  EXPECT_EQ(quotas.Of("ana").sessions, 3u);
}

TEST(QuotaOptionsTest, WhereNobodyShowsWhoTheyAreOnlyANameHasAQuota) {
  const QuotaSettings settings{.each = {.scenes = 20}, .named = {"local:compute=5"}};
  const auto options = ToOptions(settings, /*everyone_is_known=*/false);
  ASSERT_TRUE(options.ok()) << options.status();
  const PrincipalQuotas quotas(*options);
  EXPECT_EQ(quotas.Of("local").scenes, 0u);
  EXPECT_EQ(quotas.Of("local").compute_s_per_minute, 5);
}

TEST(QuotaOptionsTest, WhatIsNoQuotaIsRefused) {
  for (const char* text :
       {"", "ana", "ana:", ":scenes=1", "ana:scenes", "ana:scenes=", "ana:tea=1", "ana:scenes=-1",
        "ana:scenes=1.5", "ana:compute=nan", "ana:weight=0", "ana:scenes=1,", "ana:blob-bytes=1T",
        "ana:scenes=1=2", "ana:scenes=1,scenes=2"}) {
    const absl::Status status = ParseNamedQuota(text, {}).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << text;
    EXPECT_EQ(ErrorFieldPath(status), "quota") << text;
  }
  EXPECT_FALSE(ToOptions({.named = {"ana:scenes=1", "ana:scenes=2"}}, true).ok()) << "twice";
  EXPECT_EQ(ErrorFieldPath(ToOptions({.each = {.compute_s_per_minute = NAN}}, true).status()),
            "quota-compute");
}

TEST(SceneOwnersTest, AreCountedAndKept) {
  const TemporaryFolder folder;
  const std::string path = folder / "owners";
  const SceneOwner ana{.name = "ana", .max_scenes = 2};
  {
    SceneOwners owners;
    ASSERT_EQ(owners.Open(path), absl::OkStatus());
    EXPECT_EQ(owners.Take(ana, "a"), absl::OkStatus());
    EXPECT_EQ(owners.Take(ana, "b"), absl::OkStatus());
    EXPECT_EQ(owners.Take({.name = "ben", .max_scenes = 1}, "c"), absl::OkStatus());
    EXPECT_EQ(owners.Take({}, "nobody's"), absl::OkStatus());
  }
  SceneOwners owners;
  ASSERT_EQ(owners.Open(path), absl::OkStatus());
  EXPECT_EQ(owners.OwnerOf("b"), "ana");
  EXPECT_EQ(owners.OwnerOf("nobody's"), "");
  const absl::Status over = owners.Take(ana, "d");
  EXPECT_EQ(ErrorReason(over), "QUOTA_SCENES");
  EXPECT_EQ(ErrorFieldPath(over), "scene_id");
  EXPECT_NE(over.message().find("found 2 scenes"), absl::string_view::npos) << over;
  owners.Drop("a");
  EXPECT_EQ(owners.Take(ana, "d"), absl::OkStatus());
  owners.KeepOnly({"c"});
  EXPECT_EQ(owners.OwnerOf("d"), "");
}

TEST(SceneOwnersTest, NobodyWaitsForADiskThatStalls) {
  const TemporaryFolder folder;
  SceneOwners owners;
  ASSERT_EQ(owners.Open(folder / "owners"), absl::OkStatus());
  ASSERT_EQ(owners.Take({"ana", 2}, "first"), absl::OkStatus());
  StalledFile stalled(folder / "owners.new");
  auto taking = std::async(std::launch::async, [&] { return owners.Take({"ana", 2}, "second"); });
  while (owners.OwnerOf("second").empty() && taking.wait_for(1ms) != std::future_status::ready) {
  }
  auto asking = std::async(std::launch::async, [&] {
    owners.Drop("first");
    return owners.OwnerOf("first");
  });
  EXPECT_EQ(asking.wait_for(10s), std::future_status::ready);
  EXPECT_EQ(taking.wait_for(0s), std::future_status::timeout);
  stalled.WakeUp();
  EXPECT_EQ(taking.get().code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(owners.OwnerOf("second"), "") << "which is not written down";
  EXPECT_EQ(asking.get(), "");
}

TEST(SceneOwnersTest, AFileThatIsNoneIsSaidToBeDamaged) {
  const TemporaryFolder folder;
  for (const char* text : {"{", "[1]", "{\"a\": 1}"}) {
    std::ofstream(folder / "owners") << text;
    SceneOwners owners;
    EXPECT_EQ(owners.Open(folder / "owners").code(), absl::StatusCode::kDataLoss) << text;
    EXPECT_EQ(owners.OwnerOf("a"), "");
  }
}

}  // namespace
}  // namespace penumbra::testing
