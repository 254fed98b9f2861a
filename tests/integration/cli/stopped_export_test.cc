// penumbra scenes export that is interrupted before it has begun.
#include <gtest/gtest.h>

#include <filesystem>
#include <sstream>
#include <stop_token>

#include "client/cli/run_command.h"
#include "tests/support/hostile_server.h"
#include "tests/support/temporary_folder.h"

namespace penumbra::testing {
namespace {

TEST(StoppedExportTest, SaysSoAndLeavesNothing) {
  const TemporaryFolder folder;
  HostileServer server([](HostileServer::Stream& stream, int) { return Listen(stream); });
  ScenesExportCommand command;
  command.engine.server = server.address();
  command.scene_id = "studio";
  command.file = folder / "studio.penumbra";
  std::ostringstream out, err;
  std::stop_source stop;
  stop.request_stop();
  const absl::Status status = penumbra::Run(command, {.out = out, .err = err}, stop.get_token());
  EXPECT_EQ(status, absl::CancelledError(folder / "studio.penumbra: stopped"));
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

}  // namespace
}  // namespace penumbra::testing
