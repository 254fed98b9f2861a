#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/load/shared_scene.h"

namespace penumbra::load {
namespace {

using std::chrono::milliseconds;

TEST(LatenciesTest, CountFromWhenAnEditWasDueAndLoseNone) {
  const Clock::time_point start{std::chrono::seconds(100)};
  const auto at = [start](int ms) { return start + milliseconds(ms); };
  const std::vector<TimedEdit> edits = {{2, at(0)}, {3, at(10)}, {4, at(20)}, {5, at(30)}};
  const std::vector<Arrival> arrivals = {{1, true, at(1)},
                                         {2, true, at(7)},
                                         {3, false, at(12)},  // only that 2 still holds
                                         {4, true, at(45)}};
  EXPECT_THAT(LatenciesMs(edits, arrivals, at(2'000)), ::testing::ElementsAre(7, 35, 25, 1'970));
  EXPECT_THAT(LatenciesMs(edits, {}, at(2'000)),
              ::testing::ElementsAre(2'000, 1'990, 1'980, 1'970));
}

}  // namespace
}  // namespace penumbra::load
