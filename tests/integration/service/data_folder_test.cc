// Where the program penumbrad keeps scenes, by default and otherwise.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <initializer_list>
#include <map>
#include <string>
#include <vector>

#include "tests/integration/service/wire_client.h"
#include "tests/support/daemon.h"
#include "tests/support/temporary_folder.h"

namespace penumbra::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;

// Variables that are set while this lives; empty: unset.
class Variables {
 public:
  using Value = std::pair<std::string, std::string>;
  explicit Variables(std::initializer_list<Value> values) {
    for (const auto& [name, value] : values) {
      if (const char* before = std::getenv(name.c_str())) before_[name] = before;
      names_.push_back(name);
      Set(name, value);
    }
  }
  Variables(const Variables&) = delete;
  Variables& operator=(const Variables&) = delete;
  ~Variables() {
    for (const std::string& name : names_) Set(name, before_[name]);
  }

 private:
  static void Set(const std::string& name, const std::string& value) {
    if (value.empty()) {
      unsetenv(name.c_str());
    } else {
      setenv(name.c_str(), value.c_str(), 1);
    }
  }
  std::vector<std::string> names_;
  std::map<std::string, std::string> before_;
};

class DataFolderTest : public ::testing::Test {
 protected:
  Daemon StartByDefault(std::vector<std::string> arguments = {}) {
    arguments.insert(arguments.end(), {"--listen", "127.0.0.1:0", "--egl-device", "none"});
    return Daemon(arguments, /*keeps_scenes_by_default=*/true);
  }
  const TemporaryFolder folder_;
  const Variables variables_{{"HOME", folder_ / "home"},
                             {"XDG_DATA_HOME", ""},
                             {"STATE_DIRECTORY", ""},
                             {"PENUMBRA_DATA_DIR", ""},
                             {"PENUMBRA_EPHEMERAL", ""}};
};

TEST_F(DataFolderTest, WithoutOptionsScenesAreBackAfterARestart) {
  for (int i = 0; i < 2; ++i) {
    Daemon daemon = StartByDefault();
    WireClient client(daemon.Address());
    EXPECT_THAT(daemon.ErrorLine(), HasSubstr(folder_ / "home/.local/share/penumbra"));
    EXPECT_EQ(client.CreateScene("studio").ok(), i == 0);
    daemon.Signal(SIGKILL);
    daemon.Wait();
  }
  EXPECT_EQ(fs::status(folder_ / "home/.local/share").permissions(), fs::perms::owner_all);
  const Variables xdg{{"XDG_DATA_HOME", folder_ / "xdg"}};
  Daemon daemon = StartByDefault();
  WireClient client(daemon.Address());
  EXPECT_TRUE(client.ListScenes()->empty());
  EXPECT_TRUE(fs::exists(folder_ / "xdg/penumbra/FORMAT"));
}

TEST_F(DataFolderTest, EphemeralLeavesNothing) {
  const Variables ephemeral{{"PENUMBRA_EPHEMERAL", "true"}};
  Daemon daemon = StartByDefault();
  WireClient client(daemon.Address());
  EXPECT_THAT(daemon.ErrorLine(), HasSubstr("memory"));
  EXPECT_EQ(client.CreateScene("studio"), absl::OkStatus());
  EXPECT_FALSE(fs::exists(folder_ / "home"));
}

TEST_F(DataFolderTest, BothAreAnErrorAndSoIsNeither) {
  Daemon both = StartByDefault({"--ephemeral", "--data-dir", folder_ / "mine"});
  EXPECT_THAT(both.ErrorLine(),
              AllOf(HasSubstr("cannot_start"), HasSubstr("mine"), HasSubstr("ephemeral")));
  EXPECT_EQ(both.Wait(), EXIT_FAILURE);
  EXPECT_FALSE(fs::exists(folder_ / "mine"));
  const Variables homeless{{"HOME", ""}};
  Daemon neither = StartByDefault();
  EXPECT_THAT(neither.ErrorLine(), AllOf(HasSubstr("HOME"), HasSubstr("--ephemeral")));
  EXPECT_EQ(neither.Wait(), EXIT_FAILURE);
}

TEST_F(DataFolderTest, D08ASecondServerWithoutOptionsIsToldWhatToDo) {
  Daemon first = StartByDefault();
  first.Address();
  Daemon second = StartByDefault();
  EXPECT_THAT(second.ErrorLine(),
              AllOf(HasSubstr(folder_ / "home/.local/share/penumbra"), HasSubstr("another server"),
                    HasSubstr("--data-dir DIR"), HasSubstr("--ephemeral")));
  EXPECT_EQ(second.Wait(), EXIT_FAILURE);
  Daemon third = StartByDefault({"--data-dir", folder_ / "third"});
  EXPECT_THAT(third.OutputLine(), HasSubstr("listening on"));
}

}  // namespace
}  // namespace penumbra::testing
