#include "client/session/edit_history.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/engine/local_engine.h"
#include "render/scene/field_error.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {
namespace {

SceneDelta PutBox(const std::string& id, float x) {
  static const auto mesh = MeshOf(UnitBoxGeometry());
  SceneDelta delta;
  delta.upsert_instances = {{.id = id, .mesh = mesh, .world_from_mesh = Placed({x, 0, 0}, 1.0f)}};
  return delta;
}

// Somebody else is faster than each of the next commits.
class BusyEngine : public LocalEngine {
 public:
  absl::StatusOr<Revision> Commit(const std::string& scene_id, const SceneDelta& delta) override {
    if (faster_commits > 0) {
      const float x = static_cast<float>(faster_commits--);
      EXPECT_TRUE(LocalEngine::Commit(scene_id, PutBox("theirs", x)).ok());
    }
    return LocalEngine::Commit(scene_id, delta);
  }

  int faster_commits = 0;
};

class EditHistoryTest : public ::testing::Test {
 protected:
  void SetUp() override { ASSERT_EQ(engine_.CreateScene("studio"), absl::OkStatus()); }
  ContentHash Hash() { return (*engine_.Snapshot("studio"))->content_hash(); }

  LocalEngine engine_;
  EditHistory mine_{engine_, "studio"};
  EditHistory theirs_{engine_, "studio"};
};

TEST_F(EditHistoryTest, UndoAndRedoGoBackAndForth) {
  std::vector<ContentHash> states = {Hash()};
  for (int i = 0; i < 4; ++i) {
    // The third one moves what the first has put there.
    ASSERT_TRUE(mine_.Commit(PutBox(i == 2 ? "box0" : "box" + std::to_string(i), 1.0f * i)).ok());
    states.push_back(Hash());
  }
  SceneDelta remove;
  remove.remove_instances = {"box1"};
  ASSERT_TRUE(mine_.Commit(remove).ok());
  states.push_back(Hash());
  for (size_t i = states.size() - 1; i-- > 0;) {
    ASSERT_TRUE(mine_.Undo().ok());
    EXPECT_EQ(Hash(), states[i]) << i;
  }
  EXPECT_EQ(ErrorReason(mine_.Undo().status()), "NOTHING_TO_UNDO");
  for (size_t i = 1; i < states.size(); ++i) {
    ASSERT_TRUE(mine_.Redo().ok());
    EXPECT_EQ(Hash(), states[i]) << i;
  }
  EXPECT_EQ(ErrorReason(mine_.Redo().status()), "NOTHING_TO_REDO");
  EXPECT_EQ((*engine_.Snapshot("studio"))->revision(), 15u) << "they are commits";
}

TEST_F(EditHistoryTest, WhatOthersDidStays) {
  ASSERT_TRUE(mine_.Commit(PutBox("mine", 1)).ok());
  ASSERT_TRUE(theirs_.Commit(PutBox("theirs", 2)).ok());
  ASSERT_TRUE(mine_.Undo().ok());
  const auto scene = engine_.Snapshot("studio").value();
  EXPECT_FALSE(scene->FindInstance("mine"));
  EXPECT_TRUE(scene->FindInstance("theirs"));
  ASSERT_TRUE(mine_.Redo().ok());
  EXPECT_TRUE(engine_.Snapshot("studio").value()->FindInstance("mine"));
}

TEST_F(EditHistoryTest, WhatOthersHaveEditedSinceIsNotUndone) {
  ASSERT_TRUE(mine_.Commit(PutBox("box", 1)).ok());
  ASSERT_TRUE(theirs_.Commit(PutBox("box", 2)).ok());
  const ContentHash before = Hash();
  const absl::Status refused = mine_.Undo().status();
  EXPECT_EQ(refused.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(ErrorReason(refused), "EDITED_SINCE");
  EXPECT_EQ(ErrorFieldPath(refused), "instances[box]");
  EXPECT_EQ(Hash(), before);
}

TEST_F(EditHistoryTest, ANewEditEndsWhatCouldBeRedone) {
  ASSERT_TRUE(mine_.Commit(PutBox("a", 1)).ok());
  ASSERT_TRUE(mine_.Undo().ok());
  ASSERT_TRUE(mine_.can_redo());
  ASSERT_TRUE(mine_.Commit(PutBox("b", 1)).ok());
  EXPECT_FALSE(mine_.can_redo());
}

TEST_F(EditHistoryTest, OldEditsAreForgotten) {
  EditHistory short_history(engine_, "studio", 2);
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(short_history.Commit(PutBox("box", 1.0f * i)).ok());
  EXPECT_TRUE(short_history.Undo().ok());
  EXPECT_TRUE(short_history.Undo().ok());
  EXPECT_FALSE(short_history.can_undo());
}

TEST(BusyEditHistoryTest, TriesAgainUntilItsCommitComesFirst) {
  BusyEngine engine;
  ASSERT_EQ(engine.CreateScene("studio"), absl::OkStatus());
  EditHistory mine(engine, "studio");
  engine.faster_commits = 80;
  EXPECT_EQ(mine.Commit(PutBox("mine", 1)).value(), 81u);
  engine.faster_commits = 3;
  EXPECT_EQ(mine.Undo().value(), 85u);
  engine.faster_commits = 3;
  EXPECT_EQ(mine.Redo().value(), 89u);
}

TEST(BusyEditHistoryTest, WhoeverIsNeverFirstHearsWhy) {
  BusyEngine engine;
  ASSERT_EQ(engine.CreateScene("studio"), absl::OkStatus());
  EditHistory mine(engine, "studio", 100, /*patience_s=*/0.05);
  ASSERT_TRUE(mine.Commit(PutBox("mine", 1)).ok());
  engine.faster_commits = 1'000'000;
  for (const auto& refused : {mine.Commit(PutBox("mine", 2)), mine.Undo()}) {
    EXPECT_EQ(refused.status().code(), absl::StatusCode::kAborted);
    EXPECT_EQ(ErrorReason(refused.status()), "STALE_BASE");
    EXPECT_THAT(std::string(refused.status().message()),
                ::testing::AllOf(::testing::HasSubstr("base_revision: found that others"),
                                 ::testing::HasSubstr("trying again helps")));
  }
  EXPECT_TRUE(mine.can_undo()) << "another try may come first";
}

}  // namespace
}  // namespace penumbra::testing
