// People whose connections break, and what becomes of them and of editing.

#include <gmock/gmock.h>

#include <atomic>
#include <chrono>
#include <future>
#include <thread>

#include "render/scene/field_error.h"
#include "tests/integration/session/people.h"
#include "tests/support/fault_proxy.h"
#include "tests/support/temporary_folder.h"

namespace penumbra::testing {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double kReconnectForS = 20;

class PresenceReconnectTest : public PeopleTest {
 protected:
  void SetUp() override {
    PeopleTest::SetUp();
    relay_ = std::make_unique<FaultProxy>(server_->address());
  }
  Person EnterByRelay(const std::string& name) {
    return EnterAt(relay_->address(), name, kReconnectForS);
  }
  // Until they are another participant than `before`, and know who is here.
  static bool WaitUntilBack(const Person& person, const std::string& before) {
    return person.gallery->WaitUntil(
        [&](const Attendance& now) { return now.is_current && now.own_id != before; });
  }

  std::unique_ptr<FaultProxy> relay_;
};

TEST_F(PresenceReconnectTest, WhoeverComesBackIsKnownAgain) {
  const Person bob = Enter("Bob");
  const Person ada = EnterByRelay("Ada");
  ASSERT_EQ(ada.presence->Report({.display_name = "Ada", .colour_rgb = 7}), absl::OkStatus());
  for (int i = 0; i < 3; ++i) {
    const std::string before = ada.id();
    relay_->ResetAll();
    ASSERT_TRUE(WaitUntilBack(ada, before));
    EXPECT_THAT(NamesOf(ada.presence->attendance()), ElementsAre("Bob"));
    ASSERT_TRUE(bob.gallery->WaitUntil([&](const Attendance& now) {
      return now.others.size() == 1 && now.others[0].id == ada.id();
    }));
    EXPECT_EQ(bob.presence->attendance().others[0].presence.colour_rgb, 7u) << "as they were";
  }
  for (const PresenceChange& change : ada.gallery->changes()) {
    EXPECT_THAT(change.left, IsEmpty()) << "Bob was here all the time";
  }
}

TEST_F(PresenceReconnectTest, WhatIsSaidMeanwhileIsHeardAfterwards) {
  const Person bob = Enter("Bob");
  const Person ada = EnterByRelay("Ada");
  relay_->Refuse(true);
  relay_->ResetAll();
  ASSERT_TRUE(ada.gallery->WaitUntil([](const Attendance& now) { return !now.is_current; }));
  ASSERT_TRUE(bob.gallery->WaitUntil(AreHere({})));
  ASSERT_EQ(ada.presence->Report({.display_name = "Ada on a train"}), absl::OkStatus());
  const Person eve = Enter("Eve");
  relay_->Refuse(false);
  EXPECT_TRUE(bob.gallery->WaitUntil(AreHere({"Eve", "Ada on a train"})));
  EXPECT_TRUE(ada.gallery->WaitUntil(AreHere({"Bob", "Eve"})));
}

TEST_F(PresenceReconnectTest, NobodySeesTheirOwnGhost) {
  const Person bob = Enter("Bob");
  const Person ada = EnterByRelay("Ada");
  for (int i = 0; i < 3; ++i) {
    const std::string before = ada.id();
    relay_->Orphan();  // the server goes on to take them for present
    ASSERT_TRUE(WaitUntilBack(ada, before));
  }
  EXPECT_TRUE(bob.gallery->WaitUntil(AreHere({"Ada", "Ada", "Ada", "Ada"})));
  for (const PresenceChange& change : ada.gallery->changes()) {
    EXPECT_THAT(NamesOf(change.now), Each(std::string("Bob")));
  }
  relay_->ForgetOrphans();
  EXPECT_TRUE(bob.gallery->WaitUntil(AreHere({"Ada"})));
  EXPECT_EQ(bob.presence->attendance().others[0].id, ada.id());
}

TEST_F(PresenceReconnectTest, AnEditorEditsOn) {
  const Person bob = Enter("Bob");
  const Person ada = EnterByRelay("Ada");
  ASSERT_EQ(ada.presence->TakeEditing(), absl::OkStatus());
  ASSERT_TRUE(ada.SeesThemselvesEdit());
  std::atomic<bool> is_over = false;
  auto writer = std::async(std::launch::async, [&] {
    Revision commits = 0;
    for (; !is_over; ++commits) {
      const auto revision = ada.MoveBox(0.001f * static_cast<float>(commits));
      EXPECT_TRUE(revision.ok()) << revision.status();
      // The studio itself was the first revision.
      EXPECT_EQ(revision.value_or(0), commits + 2) << "each was applied once";
    }
    return commits;
  });
  for (int i = 0; i < 6; ++i) {
    const std::string before = ada.id();
    if (i % 2 == 0) {
      relay_->ResetAll();
    } else {
      relay_->Orphan();
    }
    ASSERT_TRUE(WaitUntilBack(ada, before));
    ASSERT_TRUE(ada.SeesThemselvesEdit());
    EXPECT_EQ(ErrorReason(bob.MoveBox(0.9f).status()), "NOT_EDITOR");
  }
  is_over = true;
  EXPECT_GT(writer.get(), 6u);
}

TEST_F(PresenceReconnectTest, WhatSomebodyTookMeanwhileIsTheirs) {
  const Person bob = Enter("Bob");
  const Person ada = EnterByRelay("Ada");
  ASSERT_EQ(ada.presence->TakeEditing(), absl::OkStatus());
  ASSERT_TRUE(ada.SeesThemselvesEdit());
  relay_->Refuse(true);
  relay_->ResetAll();
  ASSERT_TRUE(bob.gallery->WaitUntil([](const Attendance& now) { return now.editor_id.empty(); }));
  ASSERT_EQ(bob.presence->TakeEditing(), absl::OkStatus());
  auto commit = std::async(std::launch::async, [&] { return ada.MoveBox(0.7f); });
  relay_->Refuse(false);
  const absl::Status refused = commit.get().status();
  EXPECT_EQ(ErrorReason(refused), "NOT_EDITOR") << refused;
  EXPECT_TRUE(
      ada.gallery->WaitUntil([](const Attendance& now) { return EditorName(now) == "Bob"; }));
  EXPECT_TRUE(bob.MoveBox(0.8f).ok());
  ASSERT_EQ(bob.presence->ReleaseEditing(/*keep_single_editor=*/true), absl::OkStatus());
  const std::string before = ada.id();
  relay_->ResetAll();
  ASSERT_TRUE(WaitUntilBack(ada, before));
  EXPECT_EQ(ErrorReason(ada.MoveBox(0.7f).status()), "NOT_EDITOR")
      << "what was lost once does not come back by itself";
}

TEST_F(PresenceReconnectTest, WhatWasAskedForIsAnswered) {
  const Person bob = Enter("Bob");
  const Person ada = EnterByRelay("Ada");
  for (int i = 0; i < 4; ++i) {
    ASSERT_EQ(ada.presence->TakeEditing(true), absl::OkStatus());
    ASSERT_TRUE(ada.SeesThemselvesEdit());
    const bool hands_over = i % 2 == 0;
    auto asked = std::async(std::launch::async, [&] {
      return hands_over ? ada.presence->HandOverEditing(bob.id())
                        : ada.presence->ReleaseEditing(/*keep_single_editor=*/i == 1);
    });
    relay_->ResetAll();
    EXPECT_EQ(asked.get(), absl::OkStatus());
    EXPECT_TRUE(bob.gallery->WaitUntil([&](const Attendance& now) {
      return hands_over ? now.edits_self() : now.editor_id.empty() && now.single_editor == (i == 1);
    }));
  }
}

TEST_F(PresenceReconnectTest, AServerThatBeginsAnewKnowsEverybodyAgain) {
  maker_.reset();
  const TemporaryFolder folder;
  const auto start = [&](const std::string& listen) {
    auto server =
        PenumbraServer::Start({.listen = listen, .opens_gl = false, .data_dir = folder / "data"});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
  };
  start("127.0.0.1:0");
  maker_ = Connect(kReconnectForS);
  ASSERT_EQ(maker_->CreateScene("studio"), absl::OkStatus());
  const Person ada = EnterAt(server_->address(), "Ada", kReconnectForS);
  const Person bob = EnterAt(server_->address(), "Bob", kReconnectForS);
  ASSERT_EQ(ada.presence->TakeEditing(), absl::OkStatus());
  ASSERT_TRUE(ada.SeesThemselvesEdit());
  const std::string before = ada.id();
  const std::string address = server_->address();
  server_->Shutdown(std::chrono::seconds(2));
  server_.reset();
  start(address);
  ASSERT_TRUE(WaitUntilBack(ada, before));
  EXPECT_TRUE(ada.gallery->WaitUntil(AreHere({"Bob"})));
  EXPECT_TRUE(bob.gallery->WaitUntil(AreHere({"Ada"})));
  EXPECT_TRUE(bob.MoveBox(0.1f).ok()) << "everybody may edit where the server begins anew";
  EXPECT_FALSE(ada.presence->attendance().single_editor);
}

TEST_F(PresenceReconnectTest, WhoeverGivesUpIsToldAndMayEnterAnew) {
  Person ada = EnterAt(relay_->address(), "Ada", 0.3);
  relay_->Refuse(true);
  relay_->ResetAll();
  ASSERT_TRUE(ada.gallery->WaitForEnd());
  EXPECT_EQ(ada.gallery->changes().back().ended.code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(ada.presence->Report({}).code(), absl::StatusCode::kUnavailable);
  relay_->Refuse(false);
  ada.presence.reset();
  absl::StatusOr<std::unique_ptr<ScenePresence>> again = absl::UnknownError("");
  for (int i = 0; i < 50 && !again.ok(); ++i) {
    again = ada.engine->Enter("studio", {.display_name = "Ada"}, nullptr);
    if (!again.ok()) std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  EXPECT_TRUE(again.ok()) << again.status();
}

}  // namespace
}  // namespace penumbra::testing
