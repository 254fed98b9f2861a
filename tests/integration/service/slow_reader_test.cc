// A client that stops reading: it costs the server no memory, holds up nobody, and gets the newest
// revision when it reads again.

#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <string>

#include "render/scene/field_error.h"
#include "tests/integration/service/studio.h"
#include "tests/support/temporary_folder.h"

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

class StalledTest : public StudioTest {
 protected:
  StalledTest() {
    options_.data_dir = folder_ / "data";  // with a history, from which to resume
    options_.limits.max_stall_seconds = 2;
  }

  const TemporaryFolder folder_;
};

TEST_F(StalledTest, C13AClientThatTakesNothingIsLetGoAndToldWhy) {
  ArtifactSpec spec = FloorSpec();
  std::get<SoftTextureParams>(spec.params).radiance = true;  // updates of 400 KB
  session_->Commit(StudioDelta(256));
  WireClient slow_client(server_->address());
  auto slow = std::make_unique<WireSession>(slow_client.stub());
  const v1::Welcome known = slow->Hello("studio");
  ASSERT_EQ(slow->Subscribe(1, spec, 1'000'000), absl::OkStatus());
  ASSERT_EQ(session_->Subscribe(1, spec, 1'000'000), absl::OkStatus());
  EXPECT_EQ(client_->ServerInfo().statistics().open_sessions(), 2u);
  Revision last = 0;
  for (const auto end = Clock::now() + kPatience; Clock::now() < end;) {
    last = CommitFor(std::chrono::seconds(1), 10, *session_);
    if (client_->ServerInfo().statistics().open_sessions() == 1) break;
  }
  EXPECT_EQ(client_->ServerInfo().statistics().open_sessions(), 1u);
  const absl::Status end = slow->End();
  EXPECT_EQ(end.code(), absl::StatusCode::kResourceExhausted) << end;
  EXPECT_EQ(ErrorReason(end), "SLOW_CONSUMER") << end;
  EXPECT_NE(end.message().find("resume"), absl::string_view::npos) << end;
  EXPECT_EQ(session_->Commit(MoveBox({1, 1, 1})).revision(), last + 1) << "others go on";

  v1::SessionRequest resume;
  resume.mutable_hello()->add_protocol_versions(1);
  resume.mutable_hello()->set_scene_id("studio");
  resume.mutable_hello()->set_mirror_scene(true);
  resume.mutable_hello()->mutable_resume()->set_incarnation(known.incarnation());
  resume.mutable_hello()->mutable_resume()->set_revision(known.scene().revision());
  resume.mutable_hello()->mutable_resume()->set_content_hash(known.scene().content_hash());
  WireSession resumed(slow_client.stub());
  resumed.Send(resume);
  const auto welcome = resumed.ReadUntil(v1::SessionResponse::kWelcome);
  ASSERT_TRUE(welcome) << resumed.End();
  EXPECT_TRUE(welcome->welcome().is_resumed());
}

TEST_F(StudioTest, C13WhoMissesUpdatesIsToldHowMany) {
  ASSERT_EQ(session_->Subscribe(1, FloorSpec(), 1), absl::OkStatus());  // credit for one
  session_->AwaitUpdate(1, FinalAt(1));  // which gives more, one at a time
  auto slow = client_->OpenSession("studio");
  ASSERT_EQ(slow->Subscribe(7, FloorSpec(), 1), absl::OkStatus());
  slow->ReadUntil(v1::SessionResponse::kArtifactUpdate);
  for (int i = 0; i < 20; ++i) {
    const Revision revision = session_->Commit(MoveBox({0.01f * i, 1, 0})).revision();
    session_->AwaitUpdate(1, FinalAt(revision));
  }
  slow->GrantCredit(7, 1);
  const auto skipped = slow->ReadUntil(v1::SessionResponse::kUpdatesSkipped);
  ASSERT_TRUE(skipped);
  EXPECT_EQ(skipped->updates_skipped().subscription_id(), 7u);
  EXPECT_GE(skipped->updates_skipped().total(), 15u);
}

}  // namespace
}  // namespace penumbra::testing
