// What `penumbra bake` writes is held against rays traced here, in double precision, from nothing
// but the JSON file and the scene.
#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "client/display/image_io.h"
#include "tests/integration/cli/run_program.h"

namespace penumbra::testing {
namespace {

using Point = std::array<double, 3>;
using Json = nlohmann::json;

Point Minus(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Point Cross(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double Dot(const Point& a, const Point& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

using Triangle = std::array<Point, 3>;

std::vector<Triangle> TrianglesOf(const std::string& obj) {
  std::vector<Point> points;
  std::vector<Triangle> triangles;
  std::istringstream lines(obj);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string kind;
    words >> kind;
    if (kind == "v") {
      Point p;
      words >> p[0] >> p[1] >> p[2];
      points.push_back(p);
    } else if (kind == "f") {
      std::vector<size_t> corners;
      for (size_t corner; words >> corner;) corners.push_back(corner - 1);
      for (size_t i = 2; i < corners.size(); ++i) {
        triangles.push_back({points[corners[0]], points[corners[i - 1]], points[corners[i]]});
      }
    }
  }
  return triangles;
}

// Whether the segment, or the ray where `to` is a direction, meets the triangle beyond its start:
// the signs of three volumes, all of one kind, say that it passes inside.
bool Blocks(const Triangle& t, const Point& from, const Point& direction, bool is_ray) {
  const Point normal = Cross(Minus(t[1], t[0]), Minus(t[2], t[0]));
  const double slope = Dot(normal, direction);
  if (slope == 0.0) return false;
  const double s = Dot(normal, Minus(t[0], from)) / slope;
  if (s <= 1e-6 || (!is_ray && s >= 1.0 - 1e-6)) return false;
  int positive = 0, negative = 0;
  for (int i = 0; i < 3; ++i) {
    const double volume = Dot(direction, Cross(Minus(t[i], from), Minus(t[(i + 1) % 3], from)));
    ++(volume >= 0.0 ? positive : negative);
  }
  return positive == 3 || negative == 3;
}

int CountAt(const Json& bake, const std::vector<Triangle>& triangles, double u, double v) {
  const Json& receiver = bake["receiver"];
  Point texel;
  for (int c = 0; c < 3; ++c) {
    texel[c] = receiver["origin"][c].get<double>() + u * receiver["edge_u"][c].get<double>() +
               v * receiver["edge_v"][c].get<double>();
  }
  int count = 0;
  for (const Json& sample : bake["light_samples"]) {
    const bool is_ray = sample.contains("direction");
    const Point target = sample[is_ray ? "direction" : "position"].get<Point>();
    const Point direction = is_ray ? target : Minus(target, texel);
    const auto blocks = [&](const Triangle& t) { return Blocks(t, texel, direction, is_ray); };
    if (std::none_of(triangles.begin(), triangles.end(), blocks)) ++count;
  }
  return count;
}

// How many texel-samples of the baked counts differ from the rays'.
int Differences(const Json& bake, const Planes& exr) {
  const std::vector<Triangle> triangles = TrianglesOf(kSceneObj);
  const int width = bake["receiver"]["width"], height = bake["receiver"]["height"];
  EXPECT_EQ(exr.width, width);
  EXPECT_EQ(exr.height, height);
  const std::vector<float>& counts = exr.values.at("count");
  int differences = 0;
  for (int j = 0; j < height; ++j) {
    for (int i = 0; i < width; ++i) {
      const int expected = CountAt(bake, triangles, (i + 0.5) / width, (j + 0.5) / height);
      differences += std::abs(expected - static_cast<int>(counts[j * width + i]));
    }
  }
  return differences;
}

class BakeTest : public ProgramTest {
 protected:
  void ExpectRaysAgree(const std::vector<std::string>& options, const std::string& name) {
    std::vector<std::string> arguments = {"bake", scene_, "--out", folder_ / "out"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const Finished bake = Run(arguments);
    ASSERT_EQ(bake.exit_status, 0) << bake.err;
    const Json json = ReadJson(folder_ / "out" / (name + ".json"));
    ASSERT_TRUE(json.is_object());
    const auto exr = ReadImage(folder_ / "out" / (name + ".exr"));
    ASSERT_TRUE(exr.ok()) << exr.status();
    const auto [least, most] = std::ranges::minmax(exr->values.at("count"));
    EXPECT_EQ(least, 0.0f) << "nothing is in full shadow";
    EXPECT_EQ(most, static_cast<float>(json["light_samples"].size())) << "nothing is fully lit";
    const double texel_samples = 1.0 * exr->width * exr->height * json["light_samples"].size();
    EXPECT_LE(Differences(json, *exr), 1e-4 * texel_samples);
  }
};

TEST_F(BakeTest, TheJsonIsEnoughToComputeTheCountsAgain) {
  ExpectRaysAgree({"--floor", "--size", "64x48", "--samples", "25", "--rect-light",
                   "-0.7 5 -0.6  1.5 0 0.1  0.1 0 1.3  4 5 6"},
                  "floor");
}

TEST_F(BakeTest, ObliquePatchesAndEveryKindOfLight) {
  const std::string patch = "-4.1 -0.2 4.3  8.3 0.4 0.3  0.2 0.6 -8.1";
  const std::vector<std::vector<std::string>> lights = {
      {"--disk-light", "0.3 6 0.2  0.1 -1 0.2  0.8  5"},
      {"--sphere-light", "0.3 6 0.2  0.5  5"},
      {"--point-light", "0.3,6,0.2,50"},
      {"--spot-light", "0.3 6 0.2  0 -1 0  50  30 60"},
      {"--sun", "0.3 1 0.2  3  4"},
  };
  for (std::vector<std::string> options : lights) {
    SCOPED_TRACE(options[0]);
    options.insert(options.end(), {"--receiver", patch, "--size", "48", "--samples", "16"});
    ExpectRaysAgree(options, "receiver");
  }
}

TEST_F(BakeTest, AServerGivesTheSameBits) {
  const std::string address = StartServer();
  const std::vector<std::string> common = {"bake",
                                           scene_,
                                           "--floor",
                                           "--samples",
                                           "32",
                                           "--size",
                                           "96x80",
                                           "--rect-light",
                                           "-1 6 -1 2 0 0 0 0 2 5",
                                           "--receiver-instance",
                                           "wall"};
  for (const bool is_remote : {false, true}) {
    std::vector<std::string> arguments = common;
    arguments.insert(arguments.end(), {"--out", folder_ / (is_remote ? "remote" : "local")});
    if (is_remote) arguments.insert(arguments.end(), {"--server", address});
    const Finished bake = Run(arguments);
    ASSERT_EQ(bake.exit_status, 0) << bake.err;
  }
  for (const char* name : {"floor", "wall"}) {
    const auto file = [&](const char* folder, const char* extension) {
      return folder_ / folder / (std::string(name) + extension);
    };
    EXPECT_EQ(ReadText(file("local", ".png")), ReadText(file("remote", ".png")));
    const std::string exr = ReadText(file("local", ".exr"));
    EXPECT_TRUE(exr == ReadText(file("remote", ".exr"))) << "the bytes differ";
    EXPECT_NE(exr.find("1970:01:01"), std::string::npos) << "the bytes depend on the time";
    Json a = ReadJson(file("local", ".json"));
    Json b = ReadJson(file("remote", ".json"));
    a.erase("timings_ms");
    b.erase("timings_ms");
    EXPECT_EQ(a, b);
  }
  EXPECT_THAT(Run({"info", "--server", address}).out, ::testing::HasSubstr("open_sessions  0"));
}

TEST_F(BakeTest, TheFilesSayWhatTheyHold) {
  const Finished bake = Run({"bake", scene_, "--out", folder_ / "out", "--size", "32x16", "--json",
                             "--exposure", "0.5", "--rect-light", "-1 6 -1 2 0 0 0 0 2 5"});
  ASSERT_EQ(bake.exit_status, 0) << bake.err;
  const Json said = Json::parse(bake.out, nullptr, false);
  ASSERT_TRUE(said.is_object()) << bake.out;
  EXPECT_EQ(said["baked"].size(), 1u);
  const Json json = ReadJson(folder_ / "out/floor.json");
  EXPECT_EQ(json["scene"], scene_);
  EXPECT_EQ(json["technique"], "soft_texture");
  EXPECT_EQ(json["parameters"]["samples"], 64);
  EXPECT_EQ(json["parameters"]["seed"], 1);
  EXPECT_EQ(json["revision"], 1);
  EXPECT_EQ(json["light"]["type"], "rectangle");
  EXPECT_EQ(json["light"]["radiance"], Json({5.0, 5.0, 5.0}));
  EXPECT_EQ(json["png"]["exposure"], 0.5);
  EXPECT_EQ(json["receiver"]["edge_u"], Json({18.0, 0.0, 0.0}));
  EXPECT_EQ(json["receiver"]["edge_v"], Json({0.0, 0.0, -12.0}));
  EXPECT_EQ(json["receiver"]["origin"], Json({-9.0, 0.0, 5.0}));
  double weight = 0.0;
  for (const Json& sample : json["light_samples"]) weight += sample["weight"].get<double>();
  EXPECT_NEAR(weight, 1.0, 1e-5);
  EXPECT_TRUE(json["timings_ms"].contains("wall"));

  // The PNG is the radiance times the exposure, encoded.
  const auto exr = ReadImage(folder_ / "out/floor.exr");
  const auto png = ReadImage(folder_ / "out/floor.png");
  ASSERT_TRUE(exr.ok() && png.ok());
  for (size_t i = 0; i < exr->values.at("R").size(); ++i) {
    const double x = std::min(1.0, 0.5 * exr->values.at("R")[i]);
    const double encoded = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
    EXPECT_NEAR(png->values.at("R")[i], encoded, 0.6 / 255) << "texel " << i;
  }
}

TEST_F(BakeTest, SeveralLightsNameTheirFiles) {
  const Finished bake =
      Run({"bake", scene_, "--out", folder_ / "out", "--size", "8", "--floor", "--receiver",
           "-1 0 1 2 0 0 0 0 -2", "--sun", "0 1 0 1", "--point-light", "0 5 0 1"});
  ASSERT_EQ(bake.exit_status, 0) << bake.err;
  for (const char* name :
       {"floor.sun", "floor.point-light", "receiver.sun", "receiver.point-light"}) {
    for (const char* extension : {".exr", ".png", ".json"}) {
      EXPECT_TRUE(std::filesystem::exists(folder_ / "out" / (std::string(name) + extension)))
          << name;
    }
  }
}

// A map's files, and what it takes to find a point's texel in them.
TEST_F(BakeTest, AWidthMapAsChannels) {
  const Finished bake =
      Run({"bake", scene_, "--floor", "--out", folder_ / "out", "--technique", "shadow_width",
           "--set", "resolution=64", "--spot-light", "0 6 0 0 -1 0 50 10 40", "--json"});
  ASSERT_EQ(bake.exit_status, 0) << bake.err;
  const Json said = Json::parse(bake.out, nullptr, false);
  ASSERT_EQ(said["baked"].size(), 1u) << bake.out;
  EXPECT_GE(said["baked"][0]["texels"], 32 * 32);
  std::ifstream file(folder_ / "out" / "spot-light.json");
  const Json json = Json::parse(file, nullptr, false);
  ASSERT_EQ(json["faces"].size(), 1u);
  EXPECT_EQ(json["parameters"]["resolution"], 64);
  EXPECT_EQ(json["technique"], "shadow_width");
  EXPECT_EQ(json["faces"][0]["window"].size(), 4u);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "out" / "spot-light.exr"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "out" / "spot-light.png"));
}

// One shines up from above the scene, the other all around.
TEST_F(BakeTest, ALightThatSeesNothingDoesNotKeepOthersFromBeingBaked) {
  const Finished bake =
      Run({"bake", scene_, "--out", folder_ / "out", "--technique", "layered_attenuation",
           "--samples", "4", "--set", "resolution=32", "--spot-light", "0 6 0 0 1 0 50 10 20",
           "--sphere-light", "0 6 0 0.5 5", "--json"});
  ASSERT_EQ(bake.exit_status, 0) << bake.err;
  EXPECT_THAT(bake.err, ::testing::HasSubstr("spot-light: the light sees nothing"));
  const Json said = Json::parse(bake.out, nullptr, false);
  ASSERT_EQ(said["baked"].size(), 1u) << bake.out;
  EXPECT_EQ(said["baked"][0]["light"], "sphere-light");
  EXPECT_TRUE(std::filesystem::exists(folder_ / "out" / "sphere-light.exr"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out" / "spot-light.exr"));
}

}  // namespace
}  // namespace penumbra::testing
