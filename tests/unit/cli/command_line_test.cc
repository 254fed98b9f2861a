#include "client/cli/command_line.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>
#include <string>
#include <vector>

namespace penumbra {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

using Words = std::vector<std::string>;

Words Cut(const std::string& text) {
  Words words;
  std::istringstream stream(text);
  for (std::string word; std::getline(stream, word, '|');) words.push_back(word);
  return words;
}

template <typename C>
C Parsed(const Words& words) {
  const auto command = ParseCommandLine(words);
  EXPECT_TRUE(command.ok()) << command.status();
  if (!command.ok() || !std::holds_alternative<C>(*command)) {
    ADD_FAILURE() << "another command";
    return {};
  }
  return std::get<C>(*command);
}

std::string ErrorOf(const Words& words) {
  const auto command = ParseCommandLine(words);
  EXPECT_FALSE(command.ok());
  if (command.ok()) return "";
  EXPECT_EQ(command.status().code(), absl::StatusCode::kInvalidArgument);
  const std::string message(command.status().message());
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  return message;
}

TEST(CommandLineTest, BakeInFull) {
  const auto bake = Parsed<BakeCommand>(
      Cut("bake|table.glb|--technique|soft_texture|--server|host:1|--light|sun|--rect-light|"
          "0 2 0 1 0 0 0 0 1 5|--receiver|-1,0,1 2 0 0 0 0 -2|--receiver-instance|wall|--floor|"
          "--size|128x64|--samples|16|--seed|18446744073709551615|--out|dir|--exposure|2|"
          "--reflectance|0.5|--json"));
  EXPECT_EQ(bake.engine.server, "host:1");
  EXPECT_EQ(bake.request.scene, "table.glb");
  EXPECT_THAT(bake.request.light_ids, ElementsAre("sun"));
  ASSERT_EQ(bake.request.lights.size(), 1u);
  EXPECT_EQ(bake.request.lights[0].id, "rect-light");
  EXPECT_EQ(std::get<RectangleLight>(bake.request.lights[0].shape).radiance, Vec3(5));
  ASSERT_EQ(bake.request.receivers.size(), 1u);
  EXPECT_EQ(bake.request.receivers[0],
            (Parallelogram{Vec3(-1, 0, 1), Vec3(2, 0, 0), Vec3(0, 0, -2)}));
  EXPECT_THAT(bake.request.receiver_instances, ElementsAre("wall"));
  EXPECT_TRUE(bake.request.floor);
  EXPECT_EQ(bake.request.texels, (GridSize{128, 64}));
  EXPECT_EQ(bake.request.reflectance, Vec3(0.5f));
  const auto& params = std::get<SoftTextureParams>(bake.request.params);
  EXPECT_EQ(params.samples, 16u);
  EXPECT_EQ(params.seed, 18446744073709551615u);
  EXPECT_EQ(bake.out, "dir");
  EXPECT_EQ(bake.exposure, 2.0f);
  EXPECT_TRUE(bake.json);
}

TEST(CommandLineTest, BakeDefaults) {
  const auto bake = Parsed<BakeCommand>({"bake", "a.obj", "--out", "d"});
  EXPECT_EQ(bake.engine.server, "");
  EXPECT_FALSE(bake.request.texels.has_value());
  EXPECT_EQ(std::get<SoftTextureParams>(bake.request.params), SoftTextureParams{});
  EXPECT_FALSE(bake.request.floor);
  EXPECT_FALSE(bake.exposure.has_value());
  EXPECT_EQ(bake.request.reflectance, Vec3(1.0f));
}

TEST(CommandLineTest, PlanarSurfaces) {
  const auto bake = Parsed<BakeCommand>({"bake", "a.obj", "--out", "d", "--every-polygon",
                                         "--min-area", "0.5", "--texels-per-metre", "40"});
  EXPECT_TRUE(bake.request.every_polygon);
  EXPECT_EQ(bake.request.min_area_m2, 0.5);
  EXPECT_EQ(bake.request.texels_per_metre, 40.0f);
  const auto list = Parsed<ReceiversCommand>({"receivers", "a.obj", "--count", "3", "--json"});
  EXPECT_EQ(list.scene, "a.obj");
  EXPECT_EQ(list.count, 3u);
  EXPECT_TRUE(list.json);
  EXPECT_EQ(Parsed<ReceiversCommand>({"receivers", "a.obj"}).count, 20u);
  for (const char* area : {"x", "nan", "1 2"}) {
    EXPECT_EQ(ParseCommandLine({"receivers", "a.obj", "--min-area", area}).status().code(),
              absl::StatusCode::kInvalidArgument)
        << area;
  }
  EXPECT_FALSE(ParseCommandLine({"receivers", "a.obj", "--texels-per-metre", "0"}).ok());
}

TEST(CommandLineTest, NumbersNeedNoQuotes) {
  const auto bare = Parsed<BakeCommand>({"bake", "--receiver", "-1", "0", "1,2", "0", "0", "0", "0",
                                         "-2", "a.obj", "--size", "32", "16", "--out", "d"});
  ASSERT_EQ(bare.request.receivers.size(), 1u);
  EXPECT_EQ(bare.request.receivers[0],
            (Parallelogram{Vec3(-1, 0, 1), Vec3(2, 0, 0), Vec3(0, 0, -2)}));
  EXPECT_EQ(bare.request.scene, "a.obj");
  EXPECT_EQ(bare.request.texels, (GridSize{32, 16}));
  const auto tied =
      Parsed<BakeCommand>({"bake", "a.obj", "--out", "d", "--receiver=-1 0 1 2 0 0 0 0 -2"});
  EXPECT_EQ(tied.request.receivers, bare.request.receivers);
}

TEST(CommandLineTest, OptionsThatRepeat) {
  const auto bake = Parsed<BakeCommand>({"bake", "a.obj", "--out", "d", "--light", "a", "--light",
                                         "b", "--point-light", "0 1 0 5", "--point-light",
                                         "0 2 0 5", "--sun", "0 1 0 1"});
  EXPECT_THAT(bake.request.light_ids, ElementsAre("a", "b"));
  std::vector<std::string> ids;
  for (const AreaLight& light : bake.request.lights) ids.push_back(light.id);
  EXPECT_THAT(ids, ElementsAre("point-light", "point-light-2", "sun"));
}

TEST(CommandLineTest, View) {
  const auto view = Parsed<ViewCommand>({"view", "a.glb", "--camera", "1 2 3 0 0 0 35", "--size",
                                         "640x480", "--out", "v.png", "--ambient", "0.1",
                                         "--receivers", "2", "--texture-size", "64"});
  ASSERT_TRUE(view.camera.has_value());
  EXPECT_EQ(view.camera->eye, Vec3(1, 2, 3));
  EXPECT_EQ(view.camera->target, Vec3(0, 0, 0));
  EXPECT_EQ(view.camera->up, Vec3(0, 1, 0));
  EXPECT_EQ(view.camera->fov_y_deg, 35.0f);
  EXPECT_EQ(view.size, (GridSize{640, 480}));
  EXPECT_EQ(view.request.texels, (GridSize{64, 64}));
  EXPECT_EQ(view.ambient, Vec3(0.1f));
  EXPECT_EQ(view.max_planar_receivers, 2u);
  EXPECT_EQ(
      Parsed<ViewCommand>({"view", "a", "--out", "v.png", "--camera", "1 2 3, 0 0 0, 0 0 1, 50"})
          .camera->up,
      Vec3(0, 0, 1));
}

TEST(CommandLineTest, TheOthers) {
  const auto push = Parsed<PushCommand>({"push", "a.ply", "--server", "h:1", "--scene", "s"});
  EXPECT_EQ(push.request.scene, "a.ply");
  EXPECT_EQ(push.engine.server, "h:1");
  EXPECT_EQ(push.scene_id, "s");
  const auto watch = Parsed<WatchCommand>({"watch", "--server", "h:1", "--scene", "s", "--updates",
                                           "3", "--receiver", "floor", "--seconds", "1.5"});
  EXPECT_EQ(watch.scene_id, "s");
  EXPECT_EQ(watch.max_updates, 3u);
  EXPECT_EQ(watch.max_seconds, 1.5);
  EXPECT_THAT(watch.receiver_ids, ElementsAre("floor"));
  EXPECT_TRUE(Parsed<TechniquesCommand>({"techniques", "--json"}).json);
  EXPECT_EQ(Parsed<InfoCommand>({"info", "--server", "h:1"}).engine.server, "h:1");
  EXPECT_EQ(Parsed<DemoCommand>({"demo", "a.glb", "--server", "h:1", "--out", "d"}).out, "d");
}

TEST(CommandLineTest, HelpNamesEveryCommandAndEveryOption) {
  EXPECT_THAT(Parsed<PrintText>({"--help"}).text,
              AllOf(HasSubstr("bake"), HasSubstr("view"), HasSubstr("push"), HasSubstr("watch"),
                    HasSubstr("techniques"), HasSubstr("info")));
  EXPECT_THAT(Parsed<PrintText>({"bake", "--help"}).text,
              AllOf(HasSubstr("--rect-light"), HasSubstr("corner edge_u edge_v radiance"),
                    HasSubstr("--floor"), HasSubstr("--samples"), HasSubstr("--out")));
  EXPECT_THAT(Parsed<PrintText>({"--version"}).text, HasSubstr("penumbra "));
}

TEST(CommandLineTest, WhatMakesNoSenseIsOneLineThatNamesIt) {
  EXPECT_THAT(ErrorOf({}), HasSubstr("subcommand"));
  EXPECT_THAT(ErrorOf({"cook"}), AllOf(HasSubstr("found \"cook\""), HasSubstr("bake, view")));
  EXPECT_THAT(ErrorOf({"cook", "--help"}), HasSubstr("found \"cook\""));
  EXPECT_THAT(ErrorOf({"bake"}), HasSubstr("SCENE"));
  EXPECT_THAT(ErrorOf({"bake", "a.obj"}), HasSubstr("--out"));
  EXPECT_THAT(ErrorOf({"bake", "a.obj", "--out", "d", "--frobnicate"}), HasSubstr("--frobnicate"));
  EXPECT_THAT(ErrorOf({"bake", "a.obj", "--out", "d", "--technique", "magic"}),
              AllOf(HasSubstr("found \"magic\""), HasSubstr("soft_texture")));
  EXPECT_THAT(ErrorOf({"bake", "a.obj", "--out", "d", "--samples", "many"}),
              HasSubstr("--samples: found \"many\""));
  EXPECT_THAT(ErrorOf({"bake", "a.obj", "--out", "d", "--samples", "-1"}), HasSubstr("--samples"));
  EXPECT_THAT(ErrorOf({"bake", "a.obj", "--out", "d", "--seed", "18446744073709551616"}),
              HasSubstr("--seed"));
  EXPECT_THAT(ErrorOf({"bake", "a.obj", "--out", "d", "--size", "0x5"}), HasSubstr("--size"));
  EXPECT_THAT(ErrorOf({"bake", "a.obj", "--out", "d", "--receiver", "1 2 3"}),
              HasSubstr("found 3 numbers, need 9"));
  EXPECT_THAT(ErrorOf({"bake", "a.obj", "--out", "d", "--rect-light", "-1 0 x"}),
              HasSubstr("--rect-light: found \"x\""));
  EXPECT_THAT(ErrorOf({"bake", "a.obj", "--out", "d", "--exposure", "0"}), HasSubstr("--exposure"));
  EXPECT_THAT(ErrorOf({"bake", "a.obj", "--out", "d", "--reflectance", "2"}),
              HasSubstr("need 0 to 1"));
  EXPECT_THAT(ErrorOf({"view", "a.obj", "--out", "v.png", "--camera", "0 0 0 0 0 0"}),
              HasSubstr("a target apart from the eye"));
  EXPECT_THAT(ErrorOf({"view", "a.obj", "--out", "v.png", "--camera", "0 0 1 0 0 0 180"}),
              HasSubstr("field of view"));
  EXPECT_THAT(ErrorOf({"push", "a.obj", "--scene", "s"}), HasSubstr("--server"));
  for (const char* address :
       {"", "localhost", "127.0.0.1", "127.0.0.1:", "[::1]", "127.0.0.1:0", "127.0.0.1:65536",
        "127.0.0.1:99999", "127.0.0.1:abc", "127.0.0.1:-1", "127.0.0.1:80x", ":7447", "unix:"}) {
    EXPECT_THAT(ErrorOf({"info", "--server", address}), HasSubstr("need HOST:PORT")) << address;
  }
  for (const char* address : {"127.0.0.1:65535", "[::1]:1", "dns:///lab.example:7447",
                              "ipv4:127.0.0.1:7447", "unix:/run/penumbra", "unix-abstract:p"}) {
    EXPECT_EQ(Parsed<InfoCommand>({"info", "--server", address}).engine.server, address);
  }
  EXPECT_THAT(ErrorOf({"bake", "a.obj", "--out", "d", "--threads", "1025"}),
              HasSubstr("--threads"));
}

TEST(CommandLineTest, AnErrorNamesTheOptionThatWasGiven) {
  const Words import = {"scenes", "import", "a.penumbra", "--server", "h:1", "--as", "söme"};
  EXPECT_THAT(ErrorOf(import), AllOf(HasSubstr("--as: "), Not(HasSubstr("--scene"))));
  EXPECT_THAT(ErrorOf({"scenes", "foo"}),
              AllOf(HasSubstr("scenes: found \"foo\""), HasSubstr("export, import")));
  EXPECT_THAT(ErrorOf({"edit-control", "one-editor", "maybe"}),
              AllOf(HasSubstr("found \"maybe\""), HasSubstr("on, off")));
  for (const char* text : {"-1", "1.5", "x", "18446744073709551616"}) {
    EXPECT_THAT(ErrorOf({"replay", "a.penumbra", "--until", text}), HasSubstr("--until: found"));
  }
  EXPECT_THAT(ErrorOf({"receivers", "a.obj", "--count", "-1"}), HasSubstr("--count: found"));
  for (const char* text : {"nan", "-1", "1e10", "inf", "x"}) {
    EXPECT_THAT(ErrorOf({"replay", "a.penumbra", "--speed", text}), HasSubstr("--speed: found"));
    EXPECT_THAT(ErrorOf({"top", "--server", "h:1", "--interval", text}),
                HasSubstr("--interval: found"));
  }
  EXPECT_EQ(Parsed<ReplayCommand>({"replay", "a.penumbra", "--speed", "1.5"}).speed, 1.5);
  EXPECT_EQ(Parsed<ReplayCommand>({"replay", "a.penumbra", "--until", "7"}).until, 7u);
}

TEST(TieNumbersToOptionsTest, TiesOnlyNumbersThatFollow) {
  EXPECT_THAT(TieNumbersToOptions({"bake", "--size", "4", "5", "a", "--out", "1", "--floor", "2"}),
              ElementsAre("bake", "--size=4 5", "a", "--out", "1", "--floor", "2"));
  EXPECT_THAT(TieNumbersToOptions({"--receiver"}), ElementsAre("--receiver"));
  EXPECT_THAT(TieNumbersToOptions({"--receiver", "--floor"}), ElementsAre("--receiver", "--floor"));
}

}  // namespace
}  // namespace penumbra
