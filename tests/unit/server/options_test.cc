// Where penumbrad's options come from, and which source wins.

#include "server/options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <string>

#include "server/data_folder.h"
#include "tests/support/temporary_folder.h"

namespace penumbra::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

class OptionsTest : public ::testing::Test {
 protected:
  std::string File(const std::string& text) {
    const std::string path = folder_ / "penumbra.toml";
    std::ofstream(path, std::ios::binary) << text;
    return path;
  }

  absl::StatusOr<CommandLine> Read(const std::vector<std::string>& arguments) {
    return ReadOptions(arguments, [this](const std::string& name) { return environment_[name]; });
  }

  std::string ErrorOf(const std::vector<std::string>& arguments) {
    const auto command = Read(arguments);
    EXPECT_EQ(command.status().code(), absl::StatusCode::kInvalidArgument) << command.status();
    return std::string(command.status().message());
  }

  const TemporaryFolder folder_;
  std::map<std::string, std::string> environment_;
};

TEST_F(OptionsTest, TheCommandLineGoesBeforeTheEnvironmentBeforeTheFileBeforeTheDefault) {
  const std::string file =
      File("threads = 2\nrunners = 3\ndrain-seconds = 7\nlisten = \"unix:a\"\n");
  environment_ = {{"PENUMBRA_THREADS", "4"}, {"PENUMBRA_RUNNERS", "5"}};
  const auto command = Read({"--config", file, "--threads", "6"});
  ASSERT_TRUE(command.ok()) << command.status();
  EXPECT_EQ(command->server.threads, 6) << "of three";
  EXPECT_EQ(command->server.runners, 5) << "of two";
  EXPECT_EQ(command->drain_seconds, 7);
  EXPECT_EQ(command->server.listen, "unix:a");
  EXPECT_EQ(command->log_level, "info");
}

TEST_F(OptionsTest, ScenesAreKeptWhereTheFirstSays) {
  EXPECT_EQ(Read({})->server.data_dir, "");
  environment_ = {{"HOME", "/home/ana"}};
  EXPECT_EQ(Read({})->server.data_dir, "/home/ana/.local/share/penumbra");
  environment_["XDG_DATA_HOME"] = "relative";
  EXPECT_EQ(Read({})->server.data_dir, "/home/ana/.local/share/penumbra");
  environment_["XDG_DATA_HOME"] = "/data";
  EXPECT_EQ(Read({})->server.data_dir, "/data/penumbra");
  environment_["STATE_DIRECTORY"] = "/no/such/state:/other";
  EXPECT_EQ(Read({})->server.data_dir, "/no/such/state");
  // systemd's may be a link, which a server refuses.
  std::filesystem::create_directory(folder_ / "private");
  std::filesystem::create_symlink(folder_ / "private", folder_ / "state");
  environment_["STATE_DIRECTORY"] = folder_ / "state";
  EXPECT_EQ(Read({})->server.data_dir, std::filesystem::canonical(folder_ / "private"));
  EXPECT_FALSE(Read({})->has_data_dir);
  environment_["PENUMBRA_DATA_DIR"] = "/mine";
  EXPECT_EQ(Read({})->server.data_dir, "/mine");
  EXPECT_TRUE(Read({})->has_data_dir);
  EXPECT_EQ(Read({"--data-dir", "/yours"})->server.data_dir, "/yours");
}

TEST_F(OptionsTest, EphemeralComesFromEverySource) {
  environment_ = {{"HOME", "/home/ana"}};
  EXPECT_FALSE(Read({})->ephemeral);
  EXPECT_TRUE(Read({"--ephemeral"})->ephemeral);
  EXPECT_TRUE(Read({"--config", File("ephemeral = true\n")})->ephemeral);
  environment_["PENUMBRA_EPHEMERAL"] = "1";
  EXPECT_TRUE(Read({})->ephemeral);
  // What is printed of it can be read again.
  const std::string printed = Read({"--print-config"})->text;
  environment_.erase("PENUMBRA_EPHEMERAL");
  const auto again = Read({"--config", File(printed)});
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_TRUE(again->ephemeral);
  EXPECT_FALSE(again->has_data_dir);
}

TEST_F(OptionsTest, AFolderAndEphemeralExcludeEachOther) {
  EXPECT_EQ(CheckDataFolder("/a", true, false), absl::OkStatus());
  EXPECT_EQ(CheckDataFolder("/a", false, false), absl::OkStatus());
  EXPECT_EQ(CheckDataFolder("/a", false, true), absl::OkStatus());
  EXPECT_EQ(CheckDataFolder("", false, true), absl::OkStatus());
  EXPECT_THAT(std::string(CheckDataFolder("/a", true, true).message()),
              AllOf(HasSubstr("/a"), HasSubstr("ephemeral")));
  EXPECT_THAT(std::string(CheckDataFolder("", true, false).message()),
              AllOf(HasSubstr("found nothing"), HasSubstr("--ephemeral"), Not(HasSubstr("HOME"))));
  EXPECT_THAT(std::string(CheckDataFolder("", false, false).message()),
              AllOf(HasSubstr("HOME"), HasSubstr("--data-dir"), HasSubstr("--ephemeral")));
}

TEST_F(OptionsTest, TheFileIsFoundByTheEnvironmentToo) {
  environment_ = {{"PENUMBRA_CONFIG", File("reflection = true\n")}};
  EXPECT_TRUE(Read({})->server.reflection);
  environment_["PENUMBRA_REFLECTION"] = "false";
  EXPECT_FALSE(Read({})->server.reflection);
  environment_["PENUMBRA_REFLECTION"] = "";
  EXPECT_TRUE(Read({})->server.reflection) << "a variable that is empty says nothing";
}

TEST_F(OptionsTest, BadValuesNameTheOptionAndItsSource) {
  EXPECT_THAT(ErrorOf({"--threads", "many"}),
              AllOf(StartsWith("command line: "), HasSubstr("--threads"), HasSubstr("many")));
  EXPECT_THAT(ErrorOf({"--log-format", "xml"}),
              AllOf(HasSubstr("--log-format"), HasSubstr("xml"), HasSubstr("json")));
  environment_ = {{"PENUMBRA_THREADS", "5000"}};
  EXPECT_THAT(ErrorOf({}), AllOf(StartsWith("PENUMBRA_THREADS: "), HasSubstr("--threads"),
                                 HasSubstr("5000"), HasSubstr("1024")));
  environment_ = {{"PENUMBRA_REFLECTION", "perhaps"}};
  EXPECT_THAT(ErrorOf({}), AllOf(StartsWith("PENUMBRA_REFLECTION: "), HasSubstr("perhaps")));
  environment_.clear();
  const std::string file = File("drain-seconds = -1\n");
  EXPECT_THAT(ErrorOf({"--config", file}),
              AllOf(StartsWith(file + ": "), HasSubstr("--drain-seconds"), HasSubstr("-1")));
}

TEST_F(OptionsTest, WhatIsNoNumberIsNoQuota) {
  EXPECT_THAT(ErrorOf({"--quota-compute", "nan"}),
              AllOf(StartsWith("command line: --quota-compute: "), HasSubstr("'nan'")));
  environment_ = {{"PENUMBRA_QUOTA_COMPUTE", "nan"}};
  EXPECT_THAT(ErrorOf({}), StartsWith("PENUMBRA_QUOTA_COMPUTE: --quota-compute: "));
  environment_.clear();
  EXPECT_EQ(Read({"--quota-compute", "1e3"})->server.quotas.each.compute_s_per_minute, 1'000);
}

TEST_F(OptionsTest, WhatNoServerStartsWithIsNotPrinted) {
  EXPECT_THAT(ErrorOf({"--print-config", "--quota", "ana:tea=1"}),
              AllOf(StartsWith("quota: "), HasSubstr("tea=1")));
  EXPECT_THAT(ErrorOf({"--print-config", "--jwt-issuer", "x"}), StartsWith("jwt-keys: "));
  EXPECT_THAT(ErrorOf({"--print-config", "--listen", "0.0.0.0:0"}), StartsWith("listen: "));
}

TEST_F(OptionsTest, AValueThatIsNotUsedIsNotRead) {
  environment_ = {{"PENUMBRA_THREADS", "many"}};
  EXPECT_EQ(Read({"--threads", "1"})->server.threads, 1);
}

TEST_F(OptionsTest, FilesThatCannotBeMeantAreRefused) {
  EXPECT_THAT(ErrorOf({"--config", File("threds = 2\n")}), HasSubstr("'threds'"));
  EXPECT_THAT(ErrorOf({"--config", File("[server]\nthreads = 2\n")}), HasSubstr("server"));
  EXPECT_THAT(ErrorOf({"--config", File("threads = 1\nrunners = 1\nthreads = 2\n")}),
              HasSubstr("'threads' twice"));
  EXPECT_THAT(ErrorOf({"--config", File("threads = 1\nthreads = 2\n")}), HasSubstr("threads"));
  EXPECT_THAT(ErrorOf({"--config", File("# all\n\nlisten = \"127.0.0.1:0\n")}),
              AllOf(HasSubstr("line 3"), HasSubstr("quote")));
  EXPECT_THAT(ErrorOf({"--config", File("egl-device = two words\n")}), HasSubstr("egl-device"));
  EXPECT_THAT(ErrorOf({"--config", File(std::string("threads = 1\0\n", 13))}),
              HasSubstr("control character"));
  EXPECT_THAT(ErrorOf({"--config", File("config = \"b.toml\"\n")}), HasSubstr("'config'"));
  EXPECT_THAT(ErrorOf({"--config", File(std::string(2 << 20, '\n'))}), HasSubstr("1 MiB"));
  for (const std::string& missing : {folder_ / "none.toml", folder_.path()}) {
    const auto command = Read({"--config", missing});
    EXPECT_EQ(command.status().code(), absl::StatusCode::kNotFound);
    EXPECT_THAT(std::string(command.status().message()),
                AllOf(HasSubstr("--config"), HasSubstr(missing)));
  }
}

TEST_F(OptionsTest, CommentsQuotesAndHashes) {
  const auto command = Read({"--config", File("# Penumbra\n"
                                              "listen = '127.0.0.1:0'  # any port\n"
                                              "egl-device = \"no, it's #2\" # not the first\n"
                                              "\n"
                                              "threads=3\n")});
  ASSERT_TRUE(command.ok()) << command.status();
  EXPECT_EQ(command->server.listen, "127.0.0.1:0");
  EXPECT_EQ(command->server.egl_device, "no, it's #2");
  EXPECT_EQ(command->server.threads, 3);
  EXPECT_TRUE(Read({"--config", File("")}).ok());
}

TEST_F(OptionsTest, WhatIsPrintedReadsBackTheSame) {
  environment_ = {{"PENUMBRA_RUNNERS", "5"}, {"PENUMBRA_EGL_DEVICE", "Mesa \"off\" #screen"}};
  const auto printed =
      Read({"--print-config", "--reflection", "--config", File("log-level = \"debug\"\n")});
  ASSERT_TRUE(printed.ok()) << printed.status();
  EXPECT_THAT(printed->text, HasSubstr("threads = 0  # default\n"));
  EXPECT_THAT(printed->text, HasSubstr("runners = 5  # PENUMBRA_RUNNERS\n"));
  EXPECT_THAT(printed->text, HasSubstr("reflection = true  # command line\n"));
  EXPECT_THAT(printed->text, HasSubstr("log-level = \"debug\"  # " + (folder_ / "penumbra.toml")));
  environment_.clear();
  const auto command = Read({"--config", File(printed->text)});
  ASSERT_TRUE(command.ok()) << command.status() << "\n" << printed->text;
  EXPECT_EQ(command->server.runners, 5);
  EXPECT_EQ(command->server.egl_device, "Mesa \"off\" #screen");
  EXPECT_TRUE(command->server.reflection);
  EXPECT_EQ(command->log_level, "debug");
  EXPECT_EQ(command->server.listen, ServerOptions().listen);
  EXPECT_EQ(command->text, "");
  const auto again = Read({"--print-config", "--config", File(printed->text)});
  const auto values = [](const std::string& text) {
    std::string kept;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);)
      kept += line.substr(0, line.find("  # ")) + "\n";
    return kept;
  };
  EXPECT_EQ(values(again->text), values(printed->text));
}

TEST_F(OptionsTest, EveryOptionIsPrintedAndHasHelp) {
  const auto help = Read({"--help"});
  ASSERT_TRUE(help.ok()) << help.status();
  EXPECT_THAT(help->text, HasSubstr("PENUMBRA_DRAIN_SECONDS"));
  std::istringstream lines(Read({"--print-config"})->text);
  int count = 0;
  for (std::string line; std::getline(lines, line); ++count) {
    EXPECT_THAT(help->text, HasSubstr("--" + line.substr(0, line.find(' '))));
  }
  EXPECT_GE(count, 9);
  EXPECT_THAT(Read({"--version"})->text, StartsWith("penumbra "));
}

}  // namespace
}  // namespace penumbra::testing
