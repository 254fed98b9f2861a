// Row E07 of the catalogue: the server names its files itself, and none of them leads out of its
// folder.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "render/scene/field_error.h"
#include "tests/integration/service/durable_scenes.h"

namespace penumbra::testing {
namespace {

namespace fs = std::filesystem;

class DurableNamesTest : public DurableScenesTest {
 protected:
  // All that there is below the test's folder, by its path from there.
  std::vector<std::string> Everything() {
    std::vector<std::string> paths;
    const fs::path root = folder_ / "";
    for (const auto& entry : fs::recursive_directory_iterator(root)) {
      if (!entry.is_directory()) paths.push_back(fs::relative(entry.path(), root));
    }
    return paths;
  }
};

TEST_F(DurableNamesTest, E07NamesThatMeanSomethingToASystemMeanNothingHere) {
  Restart();
  const std::vector<std::string> ids = {".",
                                        "..",
                                        "...",
                                        ".hidden",
                                        "-rf",
                                        "CON",
                                        "nul.db",
                                        "LOCK",
                                        "FORMAT",
                                        "heads",
                                        "a.db",
                                        "A.db",
                                        std::string(128, '.'),
                                        std::string(128, 'x')};
  for (const std::string& id : ids) MakeStudio(id);
  const std::regex ours(R"(data/(FORMAT|LOCK|heads|owners|scenes/[A-Za-z0-9._-]+~1\.db(-wal)?|)"
                        R"(blobs/[0-9a-f]{2}/[0-9a-f]+))");
  for (const std::string& path : Everything()) {
    EXPECT_TRUE(std::regex_match(path, ours)) << path;
  }
  Restart();
  EXPECT_EQ(client_->ListScenes()->size(), ids.size());
  for (const std::string& id : ids) {
    EXPECT_EQ(client_->FindScene(id)->revision, 1u) << id;
    EXPECT_EQ(client_->DeleteScene(id), absl::OkStatus()) << id;
  }
  EXPECT_TRUE(fs::is_empty(folder_ / "data/scenes"));
}

TEST_F(DurableNamesTest, E07PathsAreNoIds) {
  Restart();
  const auto before = Everything();
  for (const std::string& id :
       {std::string("../out"), std::string("a/../../out"), folder_ / "out", std::string("scenes/x"),
        std::string("a\0b", 3), std::string("x~2"), std::string("C:\\out")}) {
    const absl::Status status = client_->CreateScene(id);
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << status;
    EXPECT_EQ(ErrorReason(status), "BAD_ID") << status;
    EXPECT_EQ(ErrorFieldPath(status), "scene_id") << status;
  }
  EXPECT_EQ(Everything(), before);
}

// A link in the place of a scene's file is not followed; what it points to stays as it is.
TEST_F(DurableNamesTest, E07ALinkInPlaceOfAFileIsNotFollowed) {
  Restart();
  MakeStudio();
  MakeStudio("other");
  server_.reset();
  const std::string outside = folder_ / "outside.db";
  fs::rename(SceneFileOf("studio"), outside);
  fs::create_symlink(outside, SceneFileOf("studio"));
  const auto written = fs::last_write_time(outside);
  Restart();
  EXPECT_EQ(logger_.Await("scene_refused", 1)[0]["scene"], "studio");
  EXPECT_FALSE(EndOfSession("studio").ok());
  EXPECT_EQ(client_->FindScene("other")->revision, 1u);
  EXPECT_EQ(fs::last_write_time(outside), written);
  EXPECT_FALSE(fs::exists(outside + "-wal"));
}

}  // namespace
}  // namespace penumbra::testing
