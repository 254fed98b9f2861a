// Sessions that go on where earlier ones ended, and who is in them.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "proto/convert/geometry_convert.h"
#include "proto/convert/status_convert.h"
#include "render/scene/field_error.h"
#include "tests/integration/service/studio.h"
#include "tests/support/temporary_folder.h"

namespace penumbra::testing {
namespace {

class ResumeTest : public StudioTest {
 protected:
  void SetUp() override {
    options_.data_dir = folder_ / "data";
    options_.storage.history = {.commits = 10, .snapshot_after_bytes = 1'500};
    StudioTest::SetUp();
  }

  struct Resumed {
    v1::Welcome welcome;
    v1::SceneUpdate first_update;
  };
  Resumed Resume(const std::string& incarnation, Revision revision, const std::string& hash) {
    other_ = std::make_unique<WireSession>(client_->stub());
    Resumed resumed;
    resumed.welcome = other_->Resume("studio", incarnation, revision, hash);
    resumed.first_update = other_->ReadUntil(v1::SessionResponse::kSceneUpdate)->scene_update();
    return resumed;
  }

  const TemporaryFolder folder_;
  std::unique_ptr<WireSession> other_;
};

TEST_F(ResumeTest, OnlyWhatWasMissedIsTold) {
  const std::string incarnation = WireSession(client_->stub()).Hello("studio").incarnation();
  const auto known = session_->Commit(MoveBox({1, 1, 0}));
  for (int i = 0; i < 4; ++i) ASSERT_FALSE(session_->Commit(MoveBox({0, 1, 0.1f * i})).has_error());
  const Resumed resumed = Resume(incarnation, known.revision(), known.content_hash());
  EXPECT_TRUE(resumed.welcome.is_resumed());
  EXPECT_EQ(resumed.welcome.incarnation(), incarnation);
  EXPECT_FALSE(resumed.first_update.is_snapshot());
  EXPECT_EQ(resumed.first_update.from_revision(), known.revision());
  EXPECT_EQ(resumed.first_update.revision(), known.revision() + 4);
  EXPECT_EQ(resumed.first_update.delta().upsert_instances_size(), 1);
  EXPECT_EQ(resumed.first_update.delta().upsert_lights_size(), 0);
}

TEST_F(ResumeTest, B13WhatIsCompactedComesAsASnapshot) {
  const std::string incarnation = WireSession(client_->stub()).Hello("studio").incarnation();
  const auto known = session_->Commit(MoveBox({1, 1, 0}));
  for (int i = 0; i < 60; ++i) {
    ASSERT_FALSE(session_->Commit(MoveBox({0, 1, 0.01f * i})).has_error());
  }
  const Resumed resumed = Resume(incarnation, known.revision(), known.content_hash());
  EXPECT_FALSE(resumed.welcome.is_resumed());
  EXPECT_TRUE(resumed.first_update.is_snapshot());
  EXPECT_EQ(resumed.first_update.delta().upsert_lights_size(), 1);
}

TEST_F(ResumeTest, ARevisionOfAnotherHistoryIsNotResumedFrom) {
  const std::string incarnation = WireSession(client_->stub()).Hello("studio").incarnation();
  const auto known = session_->Commit(MoveBox({1, 1, 0}));
  EXPECT_TRUE(
      Resume(incarnation, known.revision(), std::string(32, 'x')).first_update.is_snapshot());
  EXPECT_TRUE(Resume(std::string(16, 'x'), known.revision(), known.content_hash())
                  .first_update.is_snapshot());
  EXPECT_TRUE(Resume(incarnation, 1'000, known.content_hash()).first_update.is_snapshot());
}

TEST_F(ResumeTest, BadPointsAreRefused) {
  WireSession session(client_->stub());
  v1::SessionRequest request;
  request.mutable_hello()->add_protocol_versions(1);
  request.mutable_hello()->set_scene_id("studio");
  request.mutable_hello()->mutable_resume()->set_revision(1);
  session.Send(request);
  auto error = session.ReadUntil(v1::SessionResponse::kSessionError)->session_error();
  EXPECT_EQ(ErrorFieldPath(FromProto(error.error())), "hello.mirror_scene");
  request.mutable_hello()->set_mirror_scene(true);
  session.Send(request);
  error = session.ReadUntil(v1::SessionResponse::kSessionError)->session_error();
  EXPECT_EQ(ErrorFieldPath(FromProto(error.error())), "hello.resume.content_hash");
  EXPECT_EQ(session.Hello("studio").scene().revision(), 1u) << "the session is usable";
}

class PresenceTest : public StudioTest {
 protected:
  struct Person {
    std::unique_ptr<WireSession> session;
    std::string id;
  };
  Person Enter(const std::string& name) {
    Person person{std::make_unique<WireSession>(client_->stub()), {}};
    v1::SessionRequest request;
    request.mutable_hello()->add_protocol_versions(1);
    request.mutable_hello()->set_scene_id("studio");
    request.mutable_hello()->mutable_presence()->set_display_name(name);
    person.session->Send(request);
    person.id =
        person.session->ReadUntil(v1::SessionResponse::kWelcome)->welcome().participant_id();
    return person;
  }
  static v1::PresenceUpdate NextNews(Person& person) {
    return person.session->ReadUntil(v1::SessionResponse::kPresenceUpdate)->presence_update();
  }
  static absl::Status Control(Person& person, const v1::EditControl& control) {
    v1::SessionRequest request;
    *request.mutable_edit_control() = control;
    person.session->Send(request);
    const auto answer = person.session->ReadUntil(v1::SessionResponse::kEditControlResult);
    return FromProto(answer->edit_control_result().error());
  }
  static v1::EditControl Take(bool from_other = false) {
    v1::EditControl control;
    control.mutable_take()->set_from_other(from_other);
    return control;
  }
};

TEST_F(PresenceTest, PeopleSeeOneAnother) {
  Person ada = Enter("Ada");
  EXPECT_TRUE(NextNews(ada).participants().empty()) << "she is alone";
  Person bob = Enter("Bob \xE2\x80\xAE\x1b[31m");  // whatever it is, it is a name
  const auto seen = NextNews(bob);
  EXPECT_TRUE(seen.is_everything());
  ASSERT_EQ(seen.participants_size(), 1);
  EXPECT_EQ(seen.participants(0).presence().display_name(), "Ada");
  EXPECT_EQ(NextNews(ada).participants(0).participant_id(), bob.id);

  v1::SessionRequest report;
  report.mutable_presence()->set_display_name("Bob");
  report.mutable_presence()->set_colour_rgb(0xff8800);
  report.mutable_presence()->add_selected_ids("box");
  *report.mutable_presence()->mutable_camera() = ToProto(View{});
  bob.session->Send(report);
  const auto news = NextNews(ada);
  ASSERT_EQ(news.participants_size(), 1);
  EXPECT_EQ(news.participants(0).presence().colour_rgb(), 0xff8800u);
  EXPECT_EQ(news.participants(0).presence().selected_ids(0), "box");
  EXPECT_TRUE(news.participants(0).presence().has_camera());

  bob.session.reset();
  const auto gone = NextNews(ada);
  ASSERT_EQ(gone.left_size(), 1);
  EXPECT_EQ(gone.left(0), bob.id);
}

TEST_F(PresenceTest, B01WhatIsTooLongOrNoIdIsRefused) {
  Person ada = Enter("Ada");
  v1::SessionRequest report;
  report.mutable_presence()->set_display_name(std::string(257, 'a'));
  ada.session->Send(report);
  auto error = ada.session->ReadUntil(v1::SessionResponse::kSessionError)->session_error();
  EXPECT_EQ(ErrorFieldPath(FromProto(error.error())), "presence.display_name");
  report.mutable_presence()->set_display_name("Ada");
  report.mutable_presence()->add_selected_ids("../etc");
  ada.session->Send(report);
  error = ada.session->ReadUntil(v1::SessionResponse::kSessionError)->session_error();
  EXPECT_EQ(ErrorFieldPath(FromProto(error.error())), "presence.selected_ids[0]");
}

TEST_F(PresenceTest, OneEditsAndHandsOver) {
  Person ada = Enter("Ada"), bob = Enter("Bob");
  EXPECT_FALSE(bob.session->Commit(MoveBox({1, 1, 0})).has_error()) << "everybody may at first";
  ASSERT_EQ(Control(ada, Take()), absl::OkStatus());
  const auto refused = FromProto(bob.session->Commit(MoveBox({2, 1, 0})).error());
  EXPECT_EQ(refused.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(ErrorReason(refused), "NOT_EDITOR");
  EXPECT_EQ(ErrorReason(FromProto(session_->Commit(MoveBox({2, 1, 0})).error())), "NOT_EDITOR")
      << "whoever is not seen may not either";
  EXPECT_FALSE(ada.session->Commit(MoveBox({3, 1, 0})).has_error());
  EXPECT_EQ(ErrorReason(Control(bob, Take())), "EDITOR_PRESENT");

  v1::EditControl hand_over;
  hand_over.mutable_hand_over()->set_participant_id(bob.id);
  ASSERT_EQ(Control(ada, hand_over), absl::OkStatus());
  EXPECT_FALSE(bob.session->Commit(MoveBox({4, 1, 0})).has_error());
  EXPECT_EQ(ErrorReason(FromProto(ada.session->Commit(MoveBox({5, 1, 0})).error())), "NOT_EDITOR");
  EXPECT_EQ(ErrorReason(Control(ada, hand_over)), "NOT_EDITOR");
  ASSERT_EQ(Control(ada, Take(/*from_other=*/true)), absl::OkStatus());
  EXPECT_FALSE(ada.session->Commit(MoveBox({5, 1, 0})).has_error());

  ada.session.reset();  // an editor who leaves has left editing to whoever takes it
  v1::PresenceUpdate news;
  while (!news.editor_id().empty() || !news.single_editor()) news = NextNews(bob);
  EXPECT_EQ(ErrorReason(FromProto(bob.session->Commit(MoveBox({6, 1, 0})).error())), "NOT_EDITOR");
  ASSERT_EQ(Control(bob, Take()), absl::OkStatus());
  v1::EditControl release;
  release.mutable_release();
  ASSERT_EQ(Control(bob, release), absl::OkStatus());
  EXPECT_FALSE(session_->Commit(MoveBox({7, 1, 0})).has_error()) << "everybody may again";
}

}  // namespace
}  // namespace penumbra::testing
