// What an overload passes by, and what it must not pass by.
#include "tests/load/overload_bars.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

namespace penumbra::load {
namespace {

using ::testing::HasSubstr;

// Of commits that were all answered at once.
Outcome Carried(double rate) {
  const auto count = static_cast<size_t>(rate);
  return {.seconds = 1, .answer_ms = std::vector<double>(count, 1.0), .due = count};
}

// Four times 1,000 a second for 10 s: of 40,000 that were due 9,500 were taken and the rest refused
// or held back.
OverloadFindings Good() {
  Outcome over{.seconds = 10,
               .answer_ms = std::vector<double>(9'500, 20.0),
               .refusal_ms = std::vector<double>(5'500, 2.0),
               .due = 40'000,
               .held = 25'000,
               .late_p99_ms = 1};
  return {.maximum_per_s = 1'000, .times = 4, .over = std::move(over), .seconds_to_normal = 1};
}

std::string MissedOf(const std::function<void(OverloadFindings&)>& change) {
  OverloadFindings findings = Good();
  change(findings);
  Bars bars;
  Judge(findings, bars);
  return std::string(bars.status().message());
}

TEST(OverloadBarsTest, AnOverloadWellBornePasses) {
  EXPECT_EQ(MissedOf([](OverloadFindings&) {}), "");
}

TEST(OverloadBarsTest, ALoadThatWasNoneIsTold) {
  EXPECT_THAT(MissedOf([](auto& found) { found.over.seconds = 20; }), HasSubstr("load_reached"))
      << "the time is that which it took";
  EXPECT_THAT(MissedOf([](auto& found) { found.is_deaf = true; }), HasSubstr("load_reached"))
      << "the deaf hold nothing back";
  EXPECT_THAT(MissedOf([](auto& found) {
                found.over.refusal_ms.clear();
                found.over.held = 0;
              }),
              HasSubstr("turned_away"));
  EXPECT_THAT(MissedOf([](auto& found) { found.over.answer_ms.resize(13'500, 20.0); }),
              HasSubstr("goodput_beyond_maximum"));
}

TEST(OverloadBarsTest, AServerThatBearsItBadlyIsTold) {
  EXPECT_THAT(MissedOf([](auto& found) { found.over.answer_ms.resize(7'000); }),
              HasSubstr("goodput_of_maximum"));
  EXPECT_THAT(MissedOf([](auto& found) { found.over.refusal_ms.clear(); }),
              HasSubstr("refusal_p99_ms"))
      << "no refusal is no quick one";
  EXPECT_THAT(MissedOf([](auto& found) { found.seconds_to_normal.reset(); }),
              HasSubstr("seconds_to_normal"));
  EXPECT_THAT(MissedOf([](auto& found) { found.lost = 1; }), HasSubstr("acknowledged_and_lost"));
}

TEST(OverloadBarsTest, CommitsOfOneSceneDoNotMakeUpForAnothers) {
  const std::vector<SceneInfo> scenes = {{.id = "load0", .revision = 5},
                                         {.id = "load1", .revision = 9}};
  EXPECT_EQ(LostCommits({{"load0", 4}, {"load1", 8}}, scenes), 0u);
  EXPECT_EQ(LostCommits({{"load0", 6}, {"load1", 1}}, scenes), 2u);
  EXPECT_EQ(LostCommits({{"load0", 4}, {"load2", 3}}, scenes), 3u) << "a scene that is gone";
}

TEST(FindMaximumTest, OneNoisyStepDoesNotEndTheRamp) {
  std::map<double, int> tries;
  const auto drive = [&tries](double rate, bool is_noisy) {
    const bool is_first = ++tries[rate] == 1;
    Outcome outcome = Carried(rate);
    if (rate > 2'000 || (is_noisy && is_first)) outcome.answer_ms.assign(outcome.due, 500.0);
    return outcome;
  };
  const double quiet = FindMaximum([&](double rate) { return drive(rate, false); });
  EXPECT_GT(quiet, 1'600);
  EXPECT_LT(quiet, 2'000);
  tries.clear();
  EXPECT_EQ(FindMaximum([&](double rate) { return drive(rate, true); }), quiet);
  EXPECT_EQ(tries.rbegin()->second, kTries);
}

}  // namespace
}  // namespace penumbra::load
