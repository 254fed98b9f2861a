// People in one scene of a real server.

#include <gmock/gmock.h>

#include <chrono>
#include <future>
#include <limits>
#include <thread>

#include "render/scene/field_error.h"
#include "tests/integration/session/people.h"

namespace penumbra::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

using PresenceTest = PeopleTest;

TEST_F(PresenceTest, PeopleSeeOneAnotherComeChangeAndGo) {
  const Person ada = Enter("Ada");
  EXPECT_THAT(NamesOf(ada.presence->attendance()), IsEmpty());
  EXPECT_TRUE(ada.presence->attendance().is_current) << "the list is whole when Enter returns";
  Person bob = Enter("Bob");
  EXPECT_THAT(NamesOf(bob.presence->attendance()), ElementsAre("Ada"));
  ASSERT_TRUE(ada.gallery->WaitUntil(AreHere({"Bob"})));
  const std::string bob_id = bob.id();
  EXPECT_THAT(ada.gallery->changes().back().joined, ElementsAre(bob_id));

  const View view{.camera = {.eye = {1, 2, 3}, .fov_y_deg = 30}, .aspect = 2};
  const Presence said{
      .display_name = "Bob", .colour_rgb = 0xff8800, .view = view, .selected_ids = {"box"}};
  ASSERT_EQ(bob.presence->Report(said), absl::OkStatus());
  ASSERT_TRUE(ada.gallery->WaitUntil([&](const Attendance& now) {
    return now.others.size() == 1 && now.others[0].presence == said;
  }));
  EXPECT_THAT(ada.gallery->changes().back().changed, ElementsAre(bob_id));
  EXPECT_THAT(ada.gallery->changes().back().joined, IsEmpty());

  bob.presence.reset();
  ASSERT_TRUE(ada.gallery->WaitUntil(AreHere({})));
  ASSERT_EQ(ada.gallery->changes().back().left.size(), 1u);
  EXPECT_EQ(ada.gallery->changes().back().left[0].id, bob_id);
  EXPECT_EQ(ada.gallery->changes().back().left[0].presence, said) << "as they were last seen";
  EXPECT_TRUE(bob.MoveBox(0.1f).ok()) << "whoever is not seen any more may go on";
}

TEST_F(PresenceTest, ADraggedCameraCostsLittleAndArrives) {
  const Person ada = Enter("Ada"), bob = Enter("Bob");
  ASSERT_TRUE(ada.gallery->WaitUntil(AreHere({"Bob"})));
  const size_t before = ada.gallery->changes().size();
  const auto start = std::chrono::steady_clock::now();
  int reports = 0;
  Presence said{.display_name = "Bob"};
  while (std::chrono::steady_clock::now() - start < std::chrono::milliseconds(600)) {
    said.view = View{.camera = {.eye = {0, static_cast<float>(++reports), 5}}};
    ASSERT_EQ(bob.presence->Report(said), absl::OkStatus());
    std::this_thread::sleep_for(std::chrono::microseconds(200));
  }
  ASSERT_TRUE(ada.gallery->WaitUntil([&](const Attendance& now) {
    return now.others.at(0).presence == said;
  })) << "the last one";
  const auto took = std::chrono::steady_clock::now() - start;
  const size_t heard = ada.gallery->changes().size() - before;
  EXPECT_LE(heard, static_cast<size_t>(took / std::chrono::milliseconds(50)) + 2)
      << "of " << reports;
  EXPECT_GE(heard, 3u) << "some on the way";
}

TEST_F(PresenceTest, WhatNobodyCanBeIsRefusedByItsField) {
  const auto engine = Connect();
  const auto refused = [&](const Presence& presence) {
    const auto entered = engine->Enter("studio", presence, nullptr);
    EXPECT_EQ(entered.status().code(), absl::StatusCode::kInvalidArgument);
    return ErrorFieldPath(entered.status());
  };
  EXPECT_EQ(refused({.display_name = std::string(257, 'a')}), "presence.display_name");
  EXPECT_EQ(refused({.display_name = "\xff"}), "presence.display_name");
  EXPECT_EQ(refused({.colour_rgb = 0xff000000}), "presence.colour_rgb");
  EXPECT_EQ(refused({.selected_ids = {"a b"}}), "presence.selected_ids[0]");
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const Presence nowhere{.view = View{.camera = {.eye = {kNan, 0, 0}}}};
  EXPECT_EQ(refused(nowhere), "presence.camera.eye");

  const Person ada = Enter("Ada");
  const Person odd = Enter("\u202E\x1b[31m \n 山田👩‍🎨");
  EXPECT_TRUE(ada.gallery->WaitUntil(AreHere({"\u202E\x1b[31m \n 山田👩‍🎨"})))
      << "any text is a name";
  EXPECT_EQ(ErrorFieldPath(odd.presence->Report(nowhere)), "presence.camera.eye");
  EXPECT_TRUE(odd.presence->attendance().is_current) << "and they are still here";
  EXPECT_EQ(odd.engine->Enter("studio", {}, nullptr).status().code(),
            absl::StatusCode::kAlreadyExists);
  EXPECT_EQ(engine->Enter("nowhere", {}, nullptr).status().code(), absl::StatusCode::kNotFound);
}

TEST_F(PresenceTest, OneEditsHandsOverAndLeaves) {
  Person ada = Enter("Ada");
  const Person bob = Enter("Bob");
  EXPECT_TRUE(bob.MoveBox(0.1f).ok()) << "everybody may at first";
  ASSERT_EQ(ada.presence->TakeEditing(), absl::OkStatus());
  EXPECT_TRUE(ada.SeesThemselvesEdit());
  ASSERT_TRUE(bob.gallery->WaitUntil(
      [](const Attendance& now) { return EditorName(now) == "Ada" && !now.may_edit(); }));
  const absl::Status refused = bob.MoveBox(0.2f).status();
  EXPECT_EQ(ErrorReason(refused), "NOT_EDITOR");
  EXPECT_THAT(std::string(refused.message()), HasSubstr("found Ada (" + ada.id() + ") editing"));
  const absl::Status present = bob.presence->TakeEditing();
  EXPECT_EQ(ErrorReason(present), "EDITOR_PRESENT");
  EXPECT_THAT(std::string(present.message()), HasSubstr("found Ada ("));
  EXPECT_EQ(ErrorReason(bob.presence->ReleaseEditing()), "NOT_EDITOR");
  EXPECT_EQ(ErrorReason(bob.presence->HandOverEditing(bob.id())), "NOT_EDITOR");
  EXPECT_EQ(ErrorReason(ada.presence->HandOverEditing("nobody")), "UNKNOWN_ID");

  ASSERT_EQ(ada.presence->HandOverEditing(bob.id()), absl::OkStatus());
  EXPECT_TRUE(bob.MoveBox(0.3f).ok());
  EXPECT_EQ(ErrorReason(ada.MoveBox(0.4f).status()), "NOT_EDITOR");
  ASSERT_EQ(ada.presence->TakeEditing(/*from_other=*/true), absl::OkStatus());
  EXPECT_TRUE(ada.MoveBox(0.4f).ok());

  ada.presence.reset();
  ASSERT_TRUE(bob.gallery->WaitUntil([](const Attendance& now) {
    return now.single_editor && now.editor_id.empty();
  })) << "an editor who leaves has left editing to whoever takes it";
  EXPECT_EQ(ErrorReason(bob.MoveBox(0.5f).status()), "NOT_EDITOR");
  ASSERT_EQ(bob.presence->TakeEditing(), absl::OkStatus());
  EXPECT_TRUE(bob.MoveBox(0.5f).ok());
  ASSERT_EQ(bob.presence->ReleaseEditing(), absl::OkStatus());
  EXPECT_TRUE(ada.MoveBox(0.6f).ok()) << "everybody may again";
}

TEST_F(PresenceTest, OfTwoWhoTakeAtOnceOneGetsIt) {
  const Person ada = Enter("Ada"), bob = Enter("Bob");
  for (int i = 0; i < 20; ++i) {
    const auto take = [](const Person& person) { return person.presence->TakeEditing(); };
    auto first = std::async(std::launch::async, take, std::cref(ada));
    auto second = std::async(std::launch::async, take, std::cref(bob));
    const absl::Status of_ada = first.get(), of_bob = second.get();
    ASSERT_NE(of_ada.ok(), of_bob.ok()) << of_ada << of_bob;
    EXPECT_EQ(ErrorReason(of_ada.ok() ? of_bob : of_ada), "EDITOR_PRESENT");
    const Person& editor = of_ada.ok() ? ada : bob;
    EXPECT_TRUE(editor.MoveBox(0.01f * static_cast<float>(i)).ok());
    EXPECT_FALSE((of_ada.ok() ? bob : ada).MoveBox(0.5f).ok());
    ASSERT_EQ(editor.presence->ReleaseEditing(i % 2 == 0), absl::OkStatus());
  }
}

TEST_F(PresenceTest, WhoeverIsInTheMiddleOfSomethingMayEnterAndLeave) {
  const Person bob = Enter("Bob");
  const auto engine = Connect();  // which does not reconnect
  Inbox inbox;
  const auto subscription = engine->Subscribe("studio", FloorSpec(), inbox.callback());
  ASSERT_TRUE(inbox.WaitForFinal(1));
  for (int i = 0; i < 3; ++i) {
    std::atomic<bool> is_over = false;
    auto writer = std::async(std::launch::async, [&] {
      int commits = 0;
      for (; !is_over; ++commits) {
        const auto revision =
            engine->Commit("studio", Studio(Vec3(0.001f * static_cast<float>(commits), 0.5f, 0)));
        EXPECT_TRUE(revision.ok()) << revision.status();
      }
      return commits;
    });
    const Revision before = (*maker_->Snapshot("studio"))->revision();
    Gallery gallery;
    auto presence = engine->Enter("studio", {.display_name = "Ada"}, gallery.callback());
    ASSERT_TRUE(presence.ok()) << presence.status();
    EXPECT_THAT(NamesOf((*presence)->attendance()), ElementsAre("Bob"));
    EXPECT_TRUE(bob.gallery->WaitUntil(AreHere({"Ada"})));
    presence->reset();
    EXPECT_TRUE(bob.gallery->WaitUntil(AreHere({})));
    is_over = true;
    EXPECT_GT(writer.get(), 0);
    const Revision after = (*engine->Snapshot("studio"))->revision();
    EXPECT_GT(after, before);
    EXPECT_TRUE(inbox.WaitForFinal(after)) << "the subscription goes on";
  }
  for (const ArtifactUpdate& update : inbox.updates()) EXPECT_TRUE(update.status.ok());
}

TEST_F(PresenceTest, TheEndIsTold) {
  Person ada = Enter("Ada");
  ASSERT_EQ(maker_->DeleteScene("studio"), absl::OkStatus());
  ASSERT_TRUE(ada.gallery->WaitForEnd());
  EXPECT_EQ(ada.gallery->changes().back().ended.code(), absl::StatusCode::kNotFound);
  EXPECT_FALSE(ada.gallery->changes().back().now.is_current);
  EXPECT_EQ(ada.presence->Report({}).code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(ada.presence->TakeEditing().code(), absl::StatusCode::kNotFound);
  ASSERT_EQ(maker_->CreateScene("studio"), absl::OkStatus());
  const auto again = ada.engine->Enter("studio", {.display_name = "Ada"}, nullptr);
  EXPECT_TRUE(again.ok()) << again.status();
  ada.engine.reset();
  EXPECT_FALSE(ada.presence->attendance().is_current) << "a handle outlives its engine";
  EXPECT_FALSE((*again)->TakeEditing().ok());
}

TEST_F(PresenceTest, NoCallbackComesAfterTheEndAndOneMayEndIt) {
  Person ada = Enter("Ada");
  const auto engine = Connect();
  std::unique_ptr<ScenePresence> bob;
  std::promise<void> is_set, has_ended;
  auto entered = engine->Enter("studio", {.display_name = "Bob"},
                               [&, ready = is_set.get_future().share()](const PresenceChange& now) {
                                 ready.wait();
                                 if (!now.now.others.empty() && !now.changed.empty()) {
                                   bob.reset();  // from inside
                                   has_ended.set_value();
                                 }
                               });
  ASSERT_TRUE(entered.ok()) << entered.status();
  bob = *std::move(entered);
  is_set.set_value();
  ASSERT_EQ(ada.presence->Report({.display_name = "Ada", .colour_rgb = 1}), absl::OkStatus());
  ASSERT_EQ(has_ended.get_future().wait_for(kPatience), std::future_status::ready);
  EXPECT_TRUE(ada.gallery->WaitUntil(AreHere({})));
  for (uint32_t i = 2; i < 10; ++i) {
    ASSERT_EQ(ada.presence->Report({.display_name = "Ada", .colour_rgb = i}), absl::OkStatus());
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

}  // namespace
}  // namespace penumbra::testing
