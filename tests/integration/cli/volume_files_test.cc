// Shadow volumes from the command line: what is written is read again by importers, and crossed by
// ways between places that are known to be lit or in shadow.
#include <gmock/gmock.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "client/display/image_io.h"
#include "client/import/import_scene.h"
#include "tests/integration/cli/run_program.h"

namespace penumbra::testing {
namespace {

using Json = nlohmann::json;

// How many triangles of all instances the way from `a` to `b` meets.
int Crossings(const ImportedScene& scene, DVec3 a, DVec3 b) {
  int count = 0;
  const DVec3 way = b - a;
  for (const Instance& instance : scene.instances) {
    const auto indices = instance.mesh->indices();
    for (size_t i = 0; i < indices.size(); i += 3) {
      DVec3 p[3];
      for (size_t k = 0; k < 3; ++k) {
        p[k] = DVec3(TransformPoint(instance.world_from_mesh,
                                    instance.mesh->positions()[indices[i + k]])) -
               a;
      }
      const double ab = glm::dot(way, glm::cross(p[0], p[1]));
      const double bc = glm::dot(way, glm::cross(p[1], p[2]));
      const double ca = glm::dot(way, glm::cross(p[2], p[0]));
      if ((ab < 0) != (bc < 0) || (bc < 0) != (ca < 0)) continue;
      const DVec3 normal = glm::cross(p[1] - p[0], p[2] - p[0]);
      const double t = glm::dot(normal, p[0]) / glm::dot(normal, way);
      count += t > 0 && t < 1;
    }
  }
  return count;
}

class VolumeFilesTest : public ProgramTest {
 protected:
  // Bakes and returns what the JSON says of it.
  Json Bake(const std::vector<std::string>& light, const std::vector<std::string>& settings) {
    std::vector<std::string> words = {"bake",  scene_,          "--technique", "shadow_volume",
                                      "--out", folder_ / "out", "--set",       "resolution=128"};
    words.insert(words.end(), light.begin(), light.end());
    for (const std::string& setting : settings) words.insert(words.end(), {"--set", setting});
    const Finished bake = Run(words);
    EXPECT_EQ(bake.exit_status, 0) << bake.err;
    said_ = bake.err;
    return ReadJson(folder_ / "out" / (light[0].substr(2) + ".json"));
  }
  // The box's shadow reaches below it from 1 m on.
  void ExpectShadowOfTheBox(const std::string& name, DVec3 in_shadow, DVec3 lit) {
    for (const char* extension : {"glb", "ply", "obj"}) {
      const auto scene = ImportScene(folder_ / "out" / (name + "." + extension));
      ASSERT_TRUE(scene.ok()) << scene.status();
      const DVec3 start(4.3, 5.1, 0.37);
      EXPECT_EQ(Crossings(*scene, start, in_shadow) % 2, 1) << extension;
      EXPECT_EQ(Crossings(*scene, start, lit) % 2, 0) << extension;
      EXPECT_EQ(Crossings(*scene, in_shadow, in_shadow + DVec3(0.1, -0.2, 0.1)), 0) << extension;
    }
  }

  std::string said_;
};

TEST_F(VolumeFilesTest, BoundariesPartLightFromShadow) {
  const Json json = Bake({"--point-light", "0 6 0 10"}, {"surface=all"});
  EXPECT_EQ(json["files"].size(), 5u) << json;
  EXPECT_EQ(json["volumes"][0]["kind"], "reconstructed");
  EXPECT_GT(json["volumes"][0]["triangles"], 1000);
  EXPECT_EQ(json["parameters"]["surface"], "all");
  ExpectShadowOfTheBox("point-light", DVec3(0.23, 0.4, 0.31), DVec3(4.1, 0.2, 0.33));
  const auto depths = ReadImage(folder_ / "out/point-light.exr");
  ASSERT_TRUE(depths.ok()) << depths.status();
  // The nearest is a corner of the box's top, 3 m below the light, as the view measures it.
  const Json along = json["volumes"][0]["faces"][0]["looks_along"];
  double nearest = 9;
  for (const double x : {-1, 1}) {
    for (const double z : {-1, 1}) {
      nearest = std::min(nearest, x * along[0].get<double>() - 3 * along[1].get<double>() +
                                      z * along[2].get<double>());
    }
  }
  EXPECT_NEAR(*std::ranges::min_element(depths->values.at("depth")), nearest, 0.05);
  EXPECT_TRUE(ReadImage(folder_ / "out/point-light.png").ok());
}

// Where light is parallel all that is infinitely far is one point.
TEST_F(VolumeFilesTest, OfTheSun) {
  Bake({"--sun", "0.4 1 0.2 0.5 1"}, {"surface=all"});
  ExpectShadowOfTheBox("sun", DVec3(-0.45, 0.4, -0.2), DVec3(4.1, 0.2, 0.33));
}

// A caster's own edges need no map, and leave no picture of one.
TEST_F(VolumeFilesTest, OfEdges) {
  const Json json = Bake({"--point-light", "0 6 0 10"}, {"volumes_of=edges"});
  EXPECT_EQ(json["volumes"].size(), 2u);
  EXPECT_EQ(json["volumes"][0]["kind"], "object");
  EXPECT_EQ(json["volumes"][0]["instance"], "box");
  EXPECT_FALSE(json["files"].contains("png"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out/point-light.png"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "out/point-light.glb"));
}

TEST_F(VolumeFilesTest, ThresholdsThatSelectEverythingAreWarnedOf) {
  Bake({"--point-light", "0.3 6 0.2 10"}, {"low_threshold=0.000001", "high_threshold=0.000001"});
  EXPECT_THAT(said_, ::testing::HasSubstr("raise low_threshold"));
}

TEST_F(VolumeFilesTest, ViewsHaveLooks) {
  const auto view = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = {
        "view",      scene_, "--floor",    "--size", "48x32", "--point-light",  "0 6 0 10",
        "--ambient", "0.05", "--exposure", "1",      "--out", folder_ / "v.png"};
    words.insert(words.end(), more.begin(), more.end());
    const Finished run = Run(words);
    EXPECT_EQ(run.exit_status, 0) << run.err;
    return ReadText(folder_ / "v.png");
  };
  const std::string technique = "--technique", volume = "shadow_volume";
  const std::string plain = view({technique, volume});
  EXPECT_NE(plain, view({technique, volume, "--volume-shading", "black"}));
  EXPECT_NE(plain, view({technique, volume, "--volume-passes", "4"}));
  EXPECT_EQ(plain, view({technique, volume, "--volume-shading", "ambient"}));
  EXPECT_NE(view({technique, volume, "--volume-shading", "composited", "--volume-opacity", "0.9"}),
            view({technique, volume, "--volume-shading", "composited"}));
}

TEST_F(VolumeFilesTest, WrongLooksAreRefused) {
  const auto refusal = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = {"view", scene_, "--out", folder_ / "v.png"};
    words.insert(words.end(), more.begin(), more.end());
    const Finished run = Run(words);
    EXPECT_EQ(run.exit_status, 2) << run.err;
    return run.err;
  };
  const std::string technique = "--technique", volume = "shadow_volume";
  EXPECT_THAT(refusal({technique, volume, "--volume-shading", "grey"}),
              ::testing::HasSubstr("ambient, composited, black"));
  EXPECT_THAT(refusal({technique, volume, "--volume-opacity", "2"}),
              ::testing::HasSubstr("--volume-opacity"));
  EXPECT_THAT(refusal({technique, volume, "--volume-passes", "65"}),
              ::testing::HasSubstr("1 to 64"));
  EXPECT_THAT(refusal({technique, "shadow_width", "--volume-passes", "2"}),
              ::testing::HasSubstr("found the technique shadow_width"));
}

}  // namespace
}  // namespace penumbra::testing
