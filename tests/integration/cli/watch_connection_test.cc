// A watch by the real program whose server goes away, for good or for a moment.
#include <gmock/gmock.h>
#include <signal.h>

#include <algorithm>
#include <chrono>
#include <string>
#include <thread>
#include <utility>

#include "tests/integration/cli/run_program.h"

namespace penumbra::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class WatchConnectionTest : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    StartOn("127.0.0.1:0");
    address_ = server_->address();
    Push("-1 6 -1 2 0 0 0 0 2 5");
    watch_ = Start({"watch", "--server", address_, "--scene", "studio"}, "watch");
    ASSERT_TRUE(WaitForOutput("(final)"));
  }

  // With the scenes of the server before it.
  void StartOn(const std::string& listen) {
    auto server = PenumbraServer::Start(
        {.listen = listen, .opens_gl = false, .data_dir = (folder_ / "data").string()});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
  }
  void Stop() {
    server_->Shutdown(std::chrono::seconds(1));
    server_.reset();
  }
  void Push(const std::string& lamp) {
    const Finished pushed = Run({"push", scene_, "--server", address_, "--scene", "studio",
                                 "--floor", "--size", "32", "--rect-light", lamp});
    ASSERT_EQ(pushed.exit_status, 0) << pushed.err;
  }
  bool WaitForOutput(const std::string& text) {
    for (int i = 0; i < 400; ++i) {
      if (ReadText(folder_ / "watch.out").find(text) != std::string::npos) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return false;
  }

  std::string address_;
  pid_t watch_ = -1;
};

TEST_F(WatchConnectionTest, AServerThatDiesIsToldOnOneLineAndTheEndOnAnother) {
  Stop();
  const Finished watched = Wait(watch_, "watch");
  EXPECT_EQ(watched.exit_status, 1);
  EXPECT_EQ(std::count(watched.err.begin(), watched.err.end(), '\n'), 2) << watched.err;
  EXPECT_THAT(watched.err, AllOf(HasSubstr("note: the connection is lost"),
                                 HasSubstr("penumbra: 127.0.0.1:"), HasSubstr("gone away")));
}

TEST_F(WatchConnectionTest, TheLossIsToldOnceAndThatItIsOver) {
  Stop();
  StartOn(address_);
  Push("0 6 -1 2 0 0 0 0 2 5");
  ASSERT_TRUE(WaitForOutput("revision 2"));
  ASSERT_EQ(kill(watch_, SIGINT), 0);
  const Finished watched = Wait(watch_, "watch");
  EXPECT_EQ(watched.exit_status, 0) << watched.err;
  EXPECT_EQ(watched.err,
            "note: the connection is lost; what is shown is how it was\n"
            "note: the connection is back\n");
}

}  // namespace
}  // namespace penumbra::testing
