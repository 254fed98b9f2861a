// A client that stops reading: it costs the server no memory, holds up nobody, and gets the newest
// revision when it reads again.

#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <string>

#include "tests/integration/service/studio.h"

namespace penumbra::testing {
namespace {

using Clock = std::chrono::steady_clock;

uint64_t ResidentBytes() {
  std::ifstream statm("/proc/self/statm");
  uint64_t total = 0, resident = 0;
  statm >> total >> resident;
  return resident * static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
}

// Moves the box `count` times and for as long as `duration` at least, each time waiting for the
// shadow, and gives the last revision.
Revision CommitFor(std::chrono::seconds duration, int count, WireSession& session) {
  const auto end = Clock::now() + duration;
  Revision revision = 0;
  for (int i = 0; i < count || Clock::now() < end; ++i) {
    revision = session.Commit(MoveBox({0.001f * static_cast<float>(i % 1000), 1, 0})).revision();
    session.AwaitUpdate(1, FinalAt(revision));
  }
  return revision;
}

TEST_F(StudioTest, AClientThatStopsReadingSkipsAndThenGetsTheLast) {
  ArtifactSpec spec = FloorSpec();
  std::get<SoftTextureParams>(spec.params).radiance = true;  // updates of 400 KB
  session_->Commit(StudioDelta(256));
  WireClient slow_client(server_->address());
  auto slow = slow_client.OpenSession("studio");
  // All the credit in the world: nothing but the reading holds the server back.
  ASSERT_EQ(slow->Subscribe(1, spec, 1'000'000), absl::OkStatus());
  ASSERT_EQ(session_->Subscribe(1, spec, 1'000'000), absl::OkStatus());

  CommitFor(std::chrono::seconds(2), 20, *session_);  // the buffers of both sockets fill
  [[maybe_unused]] const uint64_t before = ResidentBytes();
  const Revision last = CommitFor(std::chrono::seconds(10), 100, *session_);
  [[maybe_unused]] const uint64_t after = ResidentBytes();
#ifndef __SANITIZE_ADDRESS__  // which keeps what has been freed
  EXPECT_LT(after, before + (24u << 20)) << "it grew by " << (after - before) / 1024 << " KiB";
#endif

  const uint64_t unread = slow->update_messages();
  EXPECT_EQ(slow->AwaitUpdate(1, FinalAt(last)).revision, last);
  EXPECT_LT(slow->update_messages() - unread, last / 2) << "it skips, it does not catch up";
}

}  // namespace
}  // namespace penumbra::testing
