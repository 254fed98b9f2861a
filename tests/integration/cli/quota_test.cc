// What the command line says of quotas, by the real program.
#include <gmock/gmock.h>

#include "tests/integration/cli/run_program.h"

namespace penumbra::testing {
namespace {

using ::testing::HasSubstr;

TEST_F(ProgramTest, WhoeverHasUsedUpTheirComputingIsToldOnce) {
  server_ = PenumbraServer::Start({.listen = "127.0.0.1:0",
                                   .opens_gl = false,
                                   .quotas = {.named = {"local:compute=0.000001"}}})
                .value();
  const std::string address = server_->address();
  const Finished pushed = Run({"push", scene_, "--server", address, "--scene", "studio", "--floor",
                               "--size", "32", "--rect-light", "-1 6 -1 2 0 0 0 0 2 5"});
  ASSERT_EQ(pushed.exit_status, 0) << pushed.err;
  const Finished watched =
      Run({"watch", "--server", address, "--scene", "studio", "--seconds", "4"});
  EXPECT_EQ(watched.exit_status, 0) << watched.err;
  EXPECT_THAT(watched.err, HasSubstr("over the quota: "));
  EXPECT_THAT(watched.err, HasSubstr("s of computing, need at most"));
  EXPECT_EQ(std::count(watched.err.begin(), watched.err.end(), '\n'), 1) << watched.err;
}

}  // namespace
}  // namespace penumbra::testing
