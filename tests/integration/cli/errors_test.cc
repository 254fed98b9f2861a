// What bad input gets: one line on standard error that starts with "penumbra: ", and a status.
#include <gmock/gmock.h>

#include <string>

#include "tests/integration/cli/run_program.h"

namespace penumbra::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

class ErrorsTest : public ProgramTest {
 protected:
  void ExpectError(const std::vector<std::string>& arguments, const std::string& fragment,
                   int exit_status = 1) {
    SCOPED_TRACE(::testing::PrintToString(arguments));
    const Finished run = Run(arguments);
    EXPECT_EQ(run.exit_status, exit_status);
    EXPECT_EQ(run.out, "");
    EXPECT_THAT(run.err, StartsWith("penumbra: "));
    EXPECT_THAT(run.err, HasSubstr(fragment));
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
  }
  std::vector<std::string> Bake(const std::vector<std::string>& more) {
    std::vector<std::string> words = {"bake", scene_, "--out", folder_ / "out"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
};

TEST_F(ErrorsTest, CommandLinesThatMakeNoSense) {
  ExpectError({}, "subcommand", 2);
  ExpectError({"bake"}, "SCENE", 2);
  ExpectError({"bake", scene_}, "--out", 2);
  ExpectError(Bake({"--rect-light", "1 2 3"}), "--rect-light: found 3 numbers, need 10 or 12", 2);
  ExpectError(Bake({"--size", "0x7"}), "--size: found \"0x7\"", 2);
  ExpectError(Bake({"--technique", "magic"}), "--technique: found \"magic\"", 2);
  ExpectError(Bake({"--min-area", "2"}), "--min-area requires --every-polygon", 2);
  ExpectError(Bake({"--receiver", "0 0 0 1 0 0 2 0 0"}), "--receiver.edge_v", 2);
  ExpectError(Bake({"--rect-light", "0 5 0 0 0 0 0 0 1 5"}), "--rect-light.edge_u", 2);
  ExpectError(Bake({"--sphere-light", "0 5 0 -1 5"}), "--sphere-light.radius", 2);
  const std::vector<std::string> watch = {"watch", "--server", "127.0.0.1:1", "--scene"};
  const auto Watch = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = watch;
    words.insert(words.end(), more.begin(), more.end());
    return words;
  };
  ExpectError(Watch({"no blanks"}), "--scene: found byte 32", 2);
  ExpectError(Watch({"s", "--seconds", "0"}), "--seconds: found \"0\", need one number above 0", 2);
  ExpectError(Watch({"s", "--updates", "0"}), "--updates: found \"0\"", 2);
}

TEST_F(ErrorsTest, FilesThatCannotBeRead) {
  ExpectError({"bake", folder_ / "none.glb", "--out", folder_ / "out"}, "none.glb");
  ExpectError({"bake", folder_, "--out", folder_ / "out"}, "need a regular file");
  std::ofstream(folder_ / "broken.glb") << "glTF and then nothing";
  ExpectError({"bake", folder_ / "broken.glb", "--out", folder_ / "out"}, "broken.glb");
  std::ofstream(folder_ / "far.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n";
  ExpectError({"bake", folder_ / "far.obj", "--out", folder_ / "out"}, "far.obj");
}

TEST_F(ErrorsTest, PlacesThatCannotBeWritten) {
  ExpectError({"bake", scene_, "--out", "/proc/penumbra"}, "/proc/penumbra: cannot be written");
  ExpectError({"bake", scene_, "--out", scene_}, "found a file, need a folder");
  ExpectError({"view", scene_, "--out", folder_ / "view.jpg"}, "ends in .png or .exr", 2);
  ExpectError({"view", scene_, "--out", "/proc/penumbra/view.png"}, "cannot be written");
}

TEST_F(ErrorsTest, ScenesThatCannotBeComputed) {
  ExpectError(Bake({"--samples", "0"}), "samples: found 0, need 1 to 1024");
  ExpectError(Bake({"--samples", "100000"}), "samples");
  ExpectError(Bake({"--light", "moon"}), "--light: found \"moon\"");
  ExpectError(Bake({"--receiver-instance", "moon"}), "--receiver-instance: found \"moon\"");
  ExpectError(Bake({"--receiver-instance", "box"}), "need an instance in one plane");
  ExpectError(Bake({"--light", "*", "--light", "moon"}), "--light: found \"*\"", 2);
  ExpectError(Bake({"--method", "coverage", "--silhouette-reuse", "4"}),
              "silhouette_reuse: found 4 with the method coverage");
}

TEST_F(ErrorsTest, OptionsOfAnotherTechnique) {
  const std::string layers = "layered_attenuation", none = folder_ / "none.glb";
  // Told before the scene is read.
  ExpectError({"bake", none, "--out", folder_ / "out", "--technique", layers, "--size", "64"},
              "--size: found the technique layered_attenuation, which has no use for it", 2);
  ExpectError(Bake({"--technique", layers, "--method", "gl"}), "--method: found the technique", 2);
  ExpectError(Bake({"--lightmap", "box"}), "need coherent_raytrace", 2);
  for (const char* option : {"--samples", "--seed"}) {
    ExpectError(Bake({"--technique", "shadow_width", option, "4"}),
                std::string(option) + ": found the technique shadow_width", 2);
  }
  const std::vector<std::string> view = {"view", none, "--out", folder_ / "v.png", "--technique"};
  const auto View = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = view;
    words.insert(words.end(), more.begin(), more.end());
    return words;
  };
  ExpectError(View({"coherent_raytrace", "--texture-size", "64"}), "--texture-size: found the", 2);
  ExpectError(View({layers, "--receivers", "2"}), "--receivers: found the technique", 2);
  ExpectError(View({"coherent_raytrace", "--final", "--final-set", "seed=2"}), "need --set", 2);
  ExpectError(View({"shadow_volume", "--volume-opacity", "0.3"}),
              "--volume-opacity: found with --volume-shading ambient", 2);
  ExpectError(View({layers, "--final", "--cull-back-faces"}),
              "--cull-back-faces: found with --final", 2);
  ExpectError(Bake({"--technique", layers, "--light", "*"}), "--light: found \"*\"", 2);
  ExpectError(
      {"watch", "--server", "127.0.0.1:1", "--scene", "s", "--technique", layers, "--light", "*"},
      "--light: found \"*\"", 2);
  ExpectError({"demo", scene_, "--server", "127.0.0.1:1", "--out", folder_ / "demo", "--technique",
               "coherent_raytrace"},
              "--technique: found \"coherent_raytrace\"", 2);
}

TEST_F(ErrorsTest, PointsThatCannotBeRead) {
  std::ofstream(folder_ / "points.txt") << "0 1 0  0 1 0\n0 1 0\n";
  const std::vector<std::string> points = {"--technique", "coherent_raytrace", "--points"};
  const auto At = [&](const std::string& file) {
    std::vector<std::string> words = points;
    words.push_back(folder_ / file);
    return Bake(words);
  };
  ExpectError(At("points.txt"), "points.txt:2: found 3 numbers, need 6");
  ExpectError(At("none.txt"), "none.txt");
}

TEST_F(ErrorsTest, ServersThatAreNotThere) {
  const std::string address = StartServer();
  server_.reset();
  ExpectError(Bake({"--server", address}), address + ": no server answers");
  ExpectError({"push", scene_, "--server", address, "--scene", "s"}, "no server answers");
  ExpectError({"watch", "--server", address, "--scene", "s"}, "no server answers");
  ExpectError({"info", "--server", address}, "no server answers");
  ExpectError({"techniques", "--server", "no host:1"}, "no host:1");
}

TEST_F(ErrorsTest, ScenesThatAServerDoesNotHave) {
  const std::string address = StartServer();
  ExpectError({"watch", "--server", address, "--scene", "nowhere"},
              "--scene: found \"nowhere\", but the server has none");
  ExpectError(Bake({"--server", address, "--samples", "0"}), "samples: found 0");
  ASSERT_EQ(Run({"push", scene_, "--server", address, "--scene", "studio", "--floor"}).exit_status,
            0);
  for (const char* option : {"--light", "--receiver"}) {
    ExpectError({"watch", "--server", address, "--scene", "studio", option, "moon"},
                std::string(option) + ": found \"moon\", need one of: ");
  }
  ExpectError({"watch", "--server", address, "--scene", "nowhere"},
              "--scene: found \"nowhere\", need one of: studio");
  EXPECT_THAT(Run({"info", "--server", address}).out, HasSubstr("statistics.open_sessions  0"));
}

}  // namespace
}  // namespace penumbra::testing
