// What the real program takes to start.
#include <gmock/gmock.h>

#include <cstdio>
#include <string>

#include "tests/integration/cli/run_program.h"

namespace penumbra::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// 260 libraries take 0.4 s to start; what needs them loads them (image_module.h).
TEST_F(ProgramTest, StartsWithoutTheLibrariesOfImageFiles) {
  FILE* const loaded = popen("LD_TRACE_LOADED_OBJECTS=1 " PENUMBRA_PROGRAM, "r");
  ASSERT_NE(loaded, nullptr);
  std::string names;
  for (char part[256]; std::fgets(part, sizeof(part), loaded) != nullptr;) names += part;
  EXPECT_EQ(pclose(loaded), 0);
  EXPECT_THAT(names, HasSubstr("libstdc++")) << "they are listed";
  EXPECT_THAT(names, Not(HasSubstr("OpenImageIO")));
}

}  // namespace
}  // namespace penumbra::testing
