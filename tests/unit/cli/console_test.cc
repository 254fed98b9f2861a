#include "client/cli/console.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

namespace penumbra {
namespace {

using ::testing::HasSubstr;

TEST(ProgressLineTest, DrawsABarOnATerminalAndLeavesNoTraceOfIt) {
  std::ostringstream out, err;
  const Console console{.out = out, .err = err, .err_is_terminal = true};
  {
    ProgressLine progress(console);
    progress.Show("floor", 0.5);
    EXPECT_THAT(err.str(), HasSubstr("[###############...............] 50 % floor"));
    progress.Show("floor", 2.0);
    EXPECT_THAT(err.str(), HasSubstr("100 %"));
  }
  EXPECT_TRUE(err.str().ends_with("\r\x1b[K"));
  EXPECT_EQ(out.str(), "");
}

TEST(ProgressLineTest, PrintsPlainLinesElsewhere) {
  std::ostringstream out, err;
  const Console console{.out = out, .err = err};
  ProgressLine progress(console);
  progress.Show("floor", 0.5);
  progress.Finish("floor: done\nwith \x1b[31mcolour");
  EXPECT_EQ(err.str(), "floor: done with  [31mcolour\n");
}

}  // namespace
}  // namespace penumbra
