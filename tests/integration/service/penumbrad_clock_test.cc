// Row C24 of the catalogue: the wall clock is set by a day while the server runs. Timers go by
// another clock; what tokens say of their end goes by this one.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <memory>
#include <string>
#include <thread>

#include "proto/convert/geometry_convert.h"
#include "render/scene/blob.h"
#include "tests/integration/security/visitor.h"
#include "tests/integration/service/studio.h"
#include "tests/support/daemon.h"
#include "tests/support/temporary_folder.h"

namespace penumbra::testing {
namespace {

using std::chrono::milliseconds, std::chrono::seconds, std::chrono::steady_clock;

constexpr int64_t kHour = 3'600, kDay = 24 * kHour;

class ClockTest : public ::testing::Test {
 protected:
  void SetUp() override {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    GTEST_SKIP() << "a sanitizer has to be the first library of a program";
#endif
    SetClock(0);
  }
  // Seconds ahead of the time that it is.
  void SetClock(int64_t ahead) {
    const int fd = open((folder_ / "clock").c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600);
    ASSERT_EQ(write(fd, &ahead, sizeof(ahead)), ssize_t{sizeof(ahead)});
    close(fd);
  }
  std::unique_ptr<Daemon> Start(std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--listen", "127.0.0.1:0", "--egl-device", "none"});
    setenv("LD_PRELOAD", SHIFTED_CLOCK, 1);
    setenv("PENUMBRA_TEST_CLOCK", (folder_ / "clock").c_str(), 1);
    auto daemon = std::make_unique<Daemon>(arguments);
    unsetenv("LD_PRELOAD");
    unsetenv("PENUMBRA_TEST_CLOCK");
    return daemon;
  }

  TemporaryFolder folder_;
};

TEST_F(ClockTest, C24SessionsUploadsAndCommitsOutliveADayForthAndTwoBack) {
  const auto daemon = Start({"--data-dir", folder_ / "data"});
  WireClient client(daemon->Address());
  ASSERT_EQ(client.CreateScene("studio"), absl::OkStatus());
  ASSERT_EQ(client.Upload(*BoxMesh()), absl::OkStatus());
  auto session = client.OpenSession("studio");
  ASSERT_EQ(session->Commit(StudioDelta()).revision(), 1u);
  ASSERT_EQ(session->Subscribe(1, FloorSpec(), 4), absl::OkStatus());

  const auto blob = EncodeBlob(UnitSquareGeometry());
  grpc::ClientContext context;
  v1::UploadBlobResponse stored;
  const auto upload = client.stub().UploadBlob(&context, &stored);
  v1::UploadBlobRequest part;
  part.mutable_header()->set_hash(ToProto(MeshOf(UnitSquareGeometry())->id()));
  part.mutable_header()->set_size_bytes(blob.size());
  part.set_data(blob.data(), 10);
  ASSERT_TRUE(upload->Write(part));
  Revision revision = 1;
  for (const int64_t ahead : {kDay, -kDay, int64_t{1}, int64_t{0}}) {
    SetClock(ahead);
    std::this_thread::sleep_for(milliseconds(1'200));  // for what looks around once a second
    EXPECT_EQ(session->Commit(MoveBox({0.1f, 1, 0.1f * static_cast<float>(++revision)})).revision(),
              revision);
    EXPECT_TRUE(session->AwaitUpdate(1, FinalAt(revision)).artifact);
  }
  part.clear_header();
  part.set_data(blob.data() + 10, blob.size() - 10);
  EXPECT_TRUE(upload->Write(part));
  upload->WritesDone();
  EXPECT_TRUE(upload->Finish().ok());
  EXPECT_EQ(stored.blobs_size(), 1);
  EXPECT_EQ(client.FindScene("studio")->revision, revision);
}

TEST_F(ClockTest, C24ADrainTakesAsLongAsItMay) {
  for (const int64_t ahead : {kDay, -kDay}) {
    const auto daemon = Start({"--drain-seconds", "3"});
    WireClient client(daemon->Address());
    grpc::ClientContext context;
    v1::UploadBlobResponse response;
    const auto silent = client.stub().UploadBlob(&context, &response);
    ASSERT_TRUE(client.ListScenes().ok());
    const auto start = steady_clock::now();
    daemon->Signal(SIGTERM);
    std::this_thread::sleep_for(milliseconds(500));
    SetClock(ahead);
    EXPECT_EQ(daemon->Wait(), 0) << ahead;
    const auto took = steady_clock::now() - start;
    EXPECT_GT(took, milliseconds(2'500)) << ahead;
    EXPECT_LT(took, milliseconds(6'500)) << ahead;
    EXPECT_FALSE(silent->Finish().ok());
    SetClock(0);
  }
}

TEST_F(ClockTest, C24TokensEndByTheWallClock) {
  Daemon maker({"token", "--name", "ana", "--role", "editor", "--scenes", "*", "--days", "1",
                "--append", folder_ / "tokens"});
  const std::string token = maker.OutputLine();
  ASSERT_EQ(maker.Wait(), 0);
  const auto daemon = Start({"--tokens", folder_ / "tokens"});
  Visitor ana(daemon->Address(), grpc::InsecureChannelCredentials(), token);
  ASSERT_EQ(ana.Create("studio"), absl::OkStatus());
  const auto session = ana.Open("Session");
  ASSERT_EQ(ana.Hello(*session, "studio"), absl::OkStatus());
  SetClock(-kDay);
  EXPECT_EQ(ana.Create("second"), absl::OkStatus());
  SetClock(kDay + kHour);
  EXPECT_EQ(ana.Create("third").code(), absl::StatusCode::kUnauthenticated);
  EXPECT_EQ(session->End().code(), absl::StatusCode::kUnauthenticated);
  SetClock(0);
  EXPECT_EQ(ana.Create("third"), absl::OkStatus());
}

}  // namespace
}  // namespace penumbra::testing
