// The table of `penumbra top`.

#include "client/cli/status_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "client/cli/server_json.h"

namespace penumbra::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using Json = nlohmann::ordered_json;

// As protobuf writes it: numbers of 64 bits as texts.
Json Status(int seconds, int edits, uint64_t bytes) {
  return {
      {"server_name", "penumbra 0.1.0"},
      {"uptime_ms", std::to_string(1000 * seconds)},
      {"is_degraded", true},
      {"statistics",
       {{"open_sessions", "2"},
        {"commits", std::to_string(edits)},
        {"sent_bytes", std::to_string(bytes)}}},
      {"scenes",
       {{{"scene_id", "quiet"}, {"revision", "7"}},
        {{"scene_id", "studio"}, {"revision", std::to_string(edits)}, {"clients", "2"}}}},
      {"clients",
       {{{"session", "4"}, {"scene_id", "studio"}, {"client_name", "idle"}, {"age_ms", "90061000"}},
        {{"session", "5"},
         {"scene_id", "studio"},
         {"client_name", "\x1b[2Jviewer\n"},
         {"sent_bytes", std::to_string(bytes)}}}}};
}

TEST(StatusTableTest, RatesAreWhatHasComeInBetween) {
  const Json before = Status(10, 100, 1'000'000), now = Status(12, 160, 5'000'000);
  const std::string table = StatusTable("h:1", &before, now, 20);
  EXPECT_THAT(table, AllOf(HasSubstr("penumbra 0.1.0 at h:1, degraded, up 00:00:12"),
                           HasSubstr("a second: 30.0 commits"), HasSubstr("2.0 MB")));
  EXPECT_LT(table.find("studio"), table.find("quiet")) << "those with most edits come first";
  EXPECT_LT(table.find("viewer"), table.find("idle")) << "and those that are sent most";
  EXPECT_THAT(table, HasSubstr("1 d 01:01:01"));
  EXPECT_THAT(table, AllOf(HasSubstr("?[2Jviewer?"), Not(HasSubstr("\x1b"))));
}

TEST(StatusTableTest, WithoutAnEarlierAnswerThereAreNoRates) {
  const Json now = Status(12, 160, 5'000'000), later_start = Status(3, 1, 1);
  EXPECT_THAT(StatusTable("h:1", nullptr, now, 20), HasSubstr("a second: - commits"));
  EXPECT_THAT(StatusTable("h:1", &now, later_start, 20), HasSubstr("a second: - commits"))
      << "the server was started anew";
}

TEST(StatusTableTest, ShowsAsManyRowsAsAskedForAndCountsTheRest) {
  const Json now = Status(12, 160, 5'000'000);
  const std::string table = StatusTable("h:1", nullptr, now, 1);
  EXPECT_THAT(table,
              AllOf(HasSubstr("… and 1 more\n"), HasSubstr("quiet"), Not(HasSubstr("viewer"))));
}

TEST(StatusTableTest, AnswersWithNothingInThemAreShown) {
  EXPECT_THAT(StatusTable("h:1", nullptr, Json::object(), 20), HasSubstr("0 sessions"));
}

TEST(CellTextTest, FillsItsColumnsWithWhatIsSafeToShow) {
  EXPECT_EQ(CellText("abc", 5), "abc  ");
  EXPECT_EQ(CellText("abcdef", 5), "abcd…");
  EXPECT_EQ(CellText("höhe", 5), "höhe ");
  EXPECT_EQ(CellText("a\x1b\n\x7f", 4), "a???");
  EXPECT_EQ(CellText("\xc2\x9b\xe2\x80\xae\xff", 4), "??? ") << "C1, bidi, no UTF-8";
  EXPECT_EQ(CellText("", 2), "  ");
}

TEST(TextTest, OfDurationsAndBytes) {
  EXPECT_EQ(DurationText(3'723), "01:02:03");
  EXPECT_EQ(DurationText(-1), "00:00:00");
  EXPECT_EQ(BytesText(999), "999 B");
  EXPECT_EQ(BytesText(12'345'678), "12.3 MB");
}

TEST(ServerJsonTest, NumbersMayBeTexts) {
  const Json json = {{"a", "12345678901"}, {"b", 3}, {"c", "x"}, {"d", nullptr}};
  EXPECT_EQ(NumberAt(json, "a"), 12345678901.0);
  EXPECT_EQ(NumberAt(json, "b"), 3);
  for (const char* none : {"c", "d", "e"}) EXPECT_EQ(NumberAt(json, none), 0);
}

}  // namespace
}  // namespace penumbra::testing
