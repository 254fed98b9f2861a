// The other commands of the real program.
#include <gmock/gmock.h>
#include <signal.h>

#include <chrono>
#include <set>
#include <string>
#include <thread>
#include <utility>

#include "client/display/image_io.h"
#include "client/session/remote_engine.h"
#include "tests/integration/cli/run_program.h"

namespace penumbra::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using Json = nlohmann::json;

std::vector<Json> JsonLines(const std::string& text) {
  std::vector<Json> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    lines.push_back(Json::parse(line, nullptr, false));
  }
  return lines;
}

class CommandsTest : public ProgramTest {
 protected:
  std::vector<std::string> PushWords(const std::string& address, const std::string& lamp) {
    return {"push",    scene_,   "--server", address,        "--scene", "studio",
            "--floor", "--size", "32",       "--rect-light", lamp,      "--json"};
  }
  // Until the file of a started program holds `text`.
  bool WaitForOutput(const std::string& name, const std::string& text) {
    for (int i = 0; i < 400; ++i) {
      if (ReadText(folder_ / (name + ".out")).find(text) != std::string::npos) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return false;
  }
};

TEST_F(CommandsTest, PushSendsOnceAndWatchSeesEachRevision) {
  const std::string address = StartServer();
  const Finished first = Run(PushWords(address, "-1 6 -1 2 0 0 0 0 2 5"));
  ASSERT_EQ(first.exit_status, 0) << first.err;
  EXPECT_EQ(Json::parse(first.out)["revision"], 1);
  EXPECT_GT(Json::parse(first.out)["blobs_sent"], 0);
  const Finished again = Run(PushWords(address, "-1 6 -1 2 0 0 0 0 2 5"));
  ASSERT_EQ(again.exit_status, 0) << again.err;
  EXPECT_EQ(Json::parse(again.out)["revision"], 1) << "nothing changed";
  EXPECT_EQ(Json::parse(again.out)["blobs_sent"], 0);

  const pid_t watch = Start({"watch", "--server", address, "--scene", "studio", "--json"}, "watch");
  ASSERT_TRUE(WaitForOutput("watch", "\"revision\":1"));
  ASSERT_EQ(Run(PushWords(address, "0 6 -1 2 0 0 0 0 2 5")).exit_status, 0);
  ASSERT_TRUE(WaitForOutput("watch", "\"revision\":2"));
  ASSERT_EQ(kill(watch, SIGINT), 0);
  const Finished watched = Wait(watch, "watch");
  EXPECT_EQ(watched.exit_status, 0) << watched.err;
  for (const Json& line : JsonLines(watched.out)) {
    ASSERT_TRUE(line.is_object()) << watched.out;
    EXPECT_EQ(line["receiver"], "floor");
    EXPECT_EQ(line["light"], "rect-light");
    EXPECT_GT(line["bytes"], 0);
    EXPECT_GE(line["latency_ms"], 0.0);
    EXPECT_TRUE(line.contains("pass"));
  }
}

TEST_F(CommandsTest, PushSendsASceneThatNoCommitHolds) {
  constexpr int kObjects = 9'000;
  {
    std::ofstream obj(scene_);
    obj << "v 0 1 0\nv 1 1 0\nv 0 1 1\n";
    for (int i = 0; i < kObjects; ++i) {
      obj << "o an-object-with-quite-a-name-" << i << "\nf 1 2 3\n";
    }
  }
  const std::string address = StartServer();
  const Finished push = Run(PushWords(address, "-1 6 -1 2 0 0 0 0 2 5"));
  ASSERT_EQ(push.exit_status, 0) << push.err;
  EXPECT_GT(Json::parse(push.out)["revision"], 1);
  auto engine = RemoteEngine::Connect({.address = address}).value();
  EXPECT_EQ((*engine->Snapshot("studio"))->instances().size(), size_t{kObjects});
  EXPECT_EQ(Run(PushWords(address, "-1 6 -1 2 0 0 0 0 2 5")).exit_status, 0) << "and again";
}

TEST_F(CommandsTest, AWatchEndsWithItsScene) {
  const std::string address = StartServer();
  ASSERT_EQ(Run(PushWords(address, "-1 6 -1 2 0 0 0 0 2 5")).exit_status, 0);
  const pid_t watch =
      Start({"watch", "--server", address, "--scene", "studio", "--seconds", "30"}, "watch");
  ASSERT_TRUE(WaitForOutput("watch", "(final)"));
  auto engine = RemoteEngine::Connect({.address = address}).value();
  SceneDelta no_lamp;
  no_lamp.remove_lights = {"rect-light"};
  ASSERT_TRUE(engine->Commit("studio", no_lamp).ok());
  ASSERT_TRUE(WaitForOutput("watch", "revision 2")) << "a light that goes is no end";
  ASSERT_EQ(engine->DeleteScene("studio"), absl::OkStatus());
  const Finished watched = Wait(watch, "watch");
  EXPECT_EQ(watched.exit_status, 1);
  EXPECT_EQ(std::count(watched.err.begin(), watched.err.end(), '\n'), 1) << watched.err;
  EXPECT_THAT(watched.err, AllOf(HasSubstr("studio"), HasSubstr("deleted")));
}

TEST_F(CommandsTest, WatchStopsAfterTheUpdatesAskedFor) {
  const std::string address = StartServer();
  ASSERT_EQ(Run(PushWords(address, "-1 6 -1 2 0 0 0 0 2 5")).exit_status, 0);
  const Finished watched =
      Run({"watch", "--server", address, "--scene", "studio", "--updates", "1", "--samples", "4"});
  EXPECT_EQ(watched.exit_status, 0) << watched.err;
  EXPECT_THAT(watched.out, AllOf(HasSubstr("revision 1"), HasSubstr("floor.rect-light"),
                                 HasSubstr("bytes"), HasSubstr("latency")));
  EXPECT_EQ(std::count(watched.out.begin(), watched.out.end(), '\n'), 1) << watched.out;
}

TEST_F(CommandsTest, WatchStopsWhenAllIsFinal) {
  const std::string address = StartServer();
  std::vector<std::string> push = PushWords(address, "-1 6 -1 2 0 0 0 0 2 5");
  push.insert(push.end(), {"--point-light", "0 5 0 3", "--receiver", "-1 0.5 1 2 0 0 0 0 -2"});
  ASSERT_EQ(Run(push).exit_status, 0);
  const Finished each = Run({"watch", "--server", address, "--scene", "studio", "--until-final",
                             "--samples", "100", "--json"});
  EXPECT_EQ(each.exit_status, 0) << each.err;
  std::set<std::pair<std::string, std::string>> final;
  for (const Json& line : JsonLines(each.out)) {
    EXPECT_FALSE(line.contains("is_late")) << "no time was asked for";
    if (line["is_final"]) final.emplace(line["receiver"], line["light"]);
  }
  EXPECT_EQ(final.size(), 4u) << each.out;

  // All lights in one: coarse at first, and then with all samples.
  const Finished all =
      Run({"watch", "--server", address, "--scene", "studio", "--until-final", "--light", "*",
           "--receiver", "floor", "--samples", "100", "--time-budget", "1e-6", "--json"});
  EXPECT_EQ(all.exit_status, 0) << all.err;
  const std::vector<Json> lines = JsonLines(all.out);
  ASSERT_GE(lines.size(), 1u);
  EXPECT_EQ(lines.back()["samples"], 101);
  for (size_t i = 0; i < lines.size(); ++i) {
    EXPECT_EQ(lines[i]["samples"], i + 1 < lines.size() ? 9 : 101);
    EXPECT_EQ(lines[i]["is_late"], i == 0) << "of what comes first, and nothing is so quick";
  }
}

TEST_F(CommandsTest, WhatComesFirstOfEachRevisionIsLateIfAnything) {
  const std::string address = StartServer();
  ASSERT_EQ(Run(PushWords(address, "-1 6 -1 2 0 0 0 0 2 5")).exit_status, 0);
  const pid_t watch = Start({"watch", "--server", address, "--scene", "studio", "--seconds", "30",
                             "--time-budget", "1e-6", "--json"},
                            "watch");
  ASSERT_TRUE(WaitForOutput("watch", "\"is_final\":true"));
  ASSERT_EQ(Run(PushWords(address, "-1 7 -1 2 0 0 0 0 2 5")).exit_status, 0);
  ASSERT_TRUE(WaitForOutput("watch", "\"computed_revision\":2"));
  auto engine = RemoteEngine::Connect({.address = address}).value();
  ASSERT_EQ(engine->DeleteScene("studio"), absl::OkStatus());
  std::set<int> revisions;
  for (const Json& line : JsonLines(Wait(watch, "watch").out)) {
    if (!line.contains("is_late")) continue;  // the deletion
    const bool comes_first = revisions.insert(line["computed_revision"].get<int>()).second;
    EXPECT_EQ(line["is_late"], comes_first) << line;
  }
  EXPECT_EQ(revisions, (std::set<int>{1, 2}));
}

TEST_F(CommandsTest, AWatchThatSeesNoEndInTimeSaysSo) {
  const std::string address = StartServer();
  ASSERT_EQ(Run(PushWords(address, "-1 6 -1 2 0 0 0 0 2 5")).exit_status, 0);
  // This server has no OpenGL, so that there are errors and never a shadow.
  const Finished watched = Run({"watch", "--server", address, "--scene", "studio", "--method", "gl",
                                "--until-final", "--seconds", "0.3"});
  EXPECT_EQ(watched.exit_status, 1);
  EXPECT_THAT(watched.out, HasSubstr("OpenGL"));
  EXPECT_THAT(watched.err, HasSubstr("found 0 of 1 shadows with all their samples after 0.3 s"));
}

TEST_F(CommandsTest, AWatchEndsWhenEveryShadowIsRefused) {
  const std::string address = StartServer();
  // All around it there is something to see, which takes six maps.
  ASSERT_EQ(Run(PushWords(address, "-0.1 0.5 -0.1 0.2 0 0 0 0 0.2 5")).exit_status, 0);
  const Finished watched =
      Run({"watch", "--server", address, "--scene", "studio", "--technique", "shadow_volume",
           "--set", "resolution=5000", "--until-final", "--seconds", "600"});
  EXPECT_EQ(watched.exit_status, 1);
  EXPECT_THAT(watched.err, HasSubstr("penumbra: shadow_volume.resolution: found"));
  EXPECT_EQ(std::count(watched.err.begin(), watched.err.end(), '\n'), 1) << watched.err;
}

TEST_F(CommandsTest, PushSaysThatNothingReceives) {
  const std::string address = StartServer();
  const Finished push = Run({"push", scene_, "--server", address, "--scene", "studio"});
  EXPECT_EQ(push.exit_status, 0);
  EXPECT_THAT(push.err, HasSubstr("no receiver is named"));
  EXPECT_THAT(Run(PushWords(address, "0 6 0 1 0 0 0 0 1 1")).err, Not(HasSubstr("no receiver")));
}

TEST_F(CommandsTest, ViewDrawsWhatItReceives) {
  const std::string address = StartServer();
  const std::string picture = folder_ / "view.png";
  const Finished view = Run({"view", scene_, "--server", address, "--floor", "--size", "160x120",
                             "--texture-size", "64", "--camera", "6 7 9, 0 1 0, 45", "--json",
                             "--rect-light", "-1 6 -1 2 0 0 0 0 2 5", "--out", picture});
  ASSERT_EQ(view.exit_status, 0) << view.err;
  EXPECT_EQ(Json::parse(view.out)["shadows"], 2) << "the floor and the wall";
  const auto png = ReadImage(picture);
  ASSERT_TRUE(png.ok()) << png.status();
  EXPECT_EQ(png->width, 160);
  EXPECT_EQ(png->height, 120);
  const auto [darkest, lightest] = std::ranges::minmax(png->values.at("G"));
  EXPECT_GT(lightest - darkest, 0.3f) << "an empty picture";
}

TEST_F(CommandsTest, TheDemonstrationMovesAnObjectAndTheLamp) {
  const std::string address = StartServer();
  const Finished demo = Run({"demo", scene_, "--server", address, "--out", folder_ / "demo",
                             "--size", "120x80", "--texture-size", "64"});
  ASSERT_EQ(demo.exit_status, 0) << demo.err;
  EXPECT_THAT(demo.out, AllOf(HasSubstr("revision 1"), HasSubstr("an object moved (revision 2)"),
                              HasSubstr("the lamp moved (revision 3)"), HasSubstr("3-lamp.png")));
  std::vector<std::string> pictures;
  for (const char* name : {"1-before.png", "2-object.png", "3-lamp.png"}) {
    pictures.push_back(ReadText(folder_ / "demo" / name));
    EXPECT_GT(pictures.back().size(), 200u) << name;
  }
  EXPECT_NE(pictures[0], pictures[1]);
  EXPECT_NE(pictures[1], pictures[2]);
  EXPECT_THAT(Run({"info", "--server", address}).out, HasSubstr("statistics.commits  3"));
}

TEST_F(CommandsTest, TechniquesAndInfoReadTheSameHereAndOnAServer) {
  const std::string address = StartServer();
  const Finished here = Run({"techniques", "--json"});
  const Finished there = Run({"techniques", "--json", "--server", address});
  EXPECT_EQ(here.exit_status, 0);
  EXPECT_EQ(Json::parse(here.out), Json::parse(there.out));
  EXPECT_THAT(Run({"techniques"}).out, HasSubstr("soft_texture"));
  EXPECT_TRUE(Json::parse(Run({"info", "--json", "--server", address}).out)["limits"].contains(
      "max_light_samples"));
}

TEST_F(CommandsTest, InfoSumsUpAServer) {
  const std::string address = StartServer();
  const std::string text = Run({"info", "--server", address}).out;
  EXPECT_THAT(text, HasSubstr(" at " + address + ", serving degraded, up 00:00:0"));
  EXPECT_THAT(text, HasSubstr("OpenGL: none: switched off"));
  EXPECT_THAT(text, HasSubstr(std::to_string(AllTechniques().size()) + " techniques, 0 sessions"));
  const Json json = Json::parse(Run({"info", "--json", "--server", address}).out, nullptr, false);
  EXPECT_EQ(json["techniques"].size(), AllTechniques().size());
}

TEST_F(CommandsTest, TopShowsScenesAndClientsWithTheirRates) {
  const std::string address = StartServer();
  ASSERT_EQ(Run({"push", scene_, "--floor", "--server", address, "--scene", "studio"}).exit_status,
            0);
  const pid_t watch = Start({"watch", "--server", address, "--scene", "studio"}, "watch");
  bool has_client = false;
  for (int i = 0; i < 400 && !has_client; ++i) {
    const Finished top = Run({"top", "--server", address, "--once", "--json"});
    has_client = Json::parse(top.out, nullptr, false)["clients"].size() == 1;
  }
  ASSERT_TRUE(has_client);
  const Finished top = Run({"top", "--server", address, "--once", "--interval", "0.2"});
  EXPECT_EQ(top.exit_status, 0) << top.err;
  EXPECT_THAT(top.out, HasSubstr("SCENE"));
  EXPECT_THAT(top.out, HasSubstr("\nstudio "));
  EXPECT_THAT(top.out, HasSubstr(" penumbra "));
  EXPECT_THAT(top.out, HasSubstr("a second: 0.0 commits"));
  EXPECT_EQ(top.out.find('\x1b'), std::string::npos) << "no terminal, no escapes";
  const pid_t live = Start({"top", "--server", address, "--interval", "0.1"}, "live");
  EXPECT_TRUE(WaitForOutput("live", "a second: 0.0"));
  kill(live, SIGINT);
  EXPECT_EQ(Wait(live, "live").exit_status, 0);
  kill(watch, SIGINT);
  Wait(watch, "watch");
}

}  // namespace
}  // namespace penumbra::testing
