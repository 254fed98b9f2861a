// What the program penumbrad tells those who run it.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/integration/service/wire_client.h"
#include "tests/support/daemon.h"
#include "tests/support/http_get.h"

namespace penumbra::testing {
namespace {

using ::testing::HasSubstr;
using Json = nlohmann::json;

// The lines of a daemon's log, read to its end.
std::vector<Json> LinesOf(Daemon& daemon) {
  std::vector<Json> lines;
  for (std::string line; !(line = daemon.ErrorLine()).empty();) {
    lines.push_back(Json::parse(line, nullptr, false));
    EXPECT_TRUE(lines.back().is_object()) << line;
  }
  return lines;
}

TEST(PenumbradTest, E08HostileClientNamesAreOneJsonObjectALine) {
  Daemon daemon({"--listen", "127.0.0.1:0", "--log-format", "json"});
  WireClient client(daemon.Address());
  ASSERT_EQ(client.CreateScene("studio"), absl::OkStatus());
  const std::vector<std::string> names = {"a\r\nb",
                                          "\x1b[31mred",
                                          "%s%n{}{0}",
                                          "\"},{\"x\":\"",
                                          "\xe2\x80\xae"
                                          "rtl",
                                          "\u2028"};
  for (const std::string& name : names) {
    WireSession session(client.stub());
    v1::SessionRequest request;
    request.mutable_hello()->set_scene_id("studio");
    request.mutable_hello()->add_protocol_versions(1);
    request.mutable_hello()->set_client_name(name);
    session.Send(request);
    EXPECT_TRUE(session.ReadUntil(v1::SessionResponse::kWelcome));
    // A megabyte of it is refused, and not logged.
    request.mutable_hello()->set_client_name(std::string(1 << 20, 'x'));
    session.Send(request);
    EXPECT_TRUE(session.ReadUntil(v1::SessionResponse::kSessionError));
  }
  daemon.Signal(SIGTERM);
  const auto lines = LinesOf(daemon);
  EXPECT_EQ(daemon.Wait(), 0);
  std::vector<std::string> seen;
  for (const Json& line : lines) {
    EXPECT_LT(line.dump().size(), 2'000u);
    if (line["event"] == "session_opened") seen.push_back(line["client"]);
  }
  EXPECT_EQ(seen, names);
  EXPECT_EQ(lines.front()["event"], "started");
  EXPECT_EQ(lines.back()["event"], "stopped");
}

TEST(PenumbradTest, ServesMetricsWhereItIsToldTo) {
  Daemon daemon(
      {"--listen", "127.0.0.1:0", "--log-format", "json", "--metrics-listen", "127.0.0.1:0"});
  const std::string address = daemon.Address();
  const Json started = Json::parse(daemon.ErrorLine(), nullptr, false);
  EXPECT_EQ(started["address"], address);
  EXPECT_THAT(HttpGet(started["metrics"], "/metrics"), HasSubstr("penumbra_uptime_seconds"));
  Daemon open({"--metrics-listen", "0.0.0.0:9464"});
  EXPECT_THAT(open.ErrorLine(),
              ::testing::AllOf(HasSubstr("metrics_listen"), HasSubstr("loopback")));
  EXPECT_EQ(open.Wait(), EXIT_FAILURE);
}

TEST(PenumbradTest, PrintsItsOptionsAndStartsNothing) {
  const std::string path =
      std::filesystem::temp_directory_path() / ("penumbrad-" + std::to_string(getpid()));
  std::ofstream(path) << "runners = 3\nlisten = \"unix:/nowhere\"\n";
  setenv("PENUMBRA_RUNNERS", "4", 1);
  Daemon daemon({"--print-config", "--config", path, "--listen", "unix:/elsewhere"});
  EXPECT_EQ(daemon.OutputLine(), "listen = \"unix:/elsewhere\"  # command line");
  EXPECT_EQ(daemon.OutputLine(), "threads = 0  # default");
  EXPECT_EQ(daemon.OutputLine(), "runners = 4  # PENUMBRA_RUNNERS");
  EXPECT_EQ(daemon.Wait(), 0);
  setenv("PENUMBRA_RUNNERS", "65", 1);
  Daemon refused({});
  EXPECT_THAT(refused.ErrorLine(), HasSubstr("PENUMBRA_RUNNERS: --runners"));
  EXPECT_EQ(refused.Wait(), EXIT_FAILURE);
  unsetenv("PENUMBRA_RUNNERS");
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace penumbra::testing
