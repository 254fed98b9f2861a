// Planar surfaces of a file: listed, baked, drawn, by the real program.
#include <gmock/gmock.h>

#include <set>
#include <string>

#include "client/display/image_io.h"
#include "tests/integration/cli/run_program.h"

namespace penumbra::testing {
namespace {

using ::testing::HasSubstr;
using Json = nlohmann::json;

class EveryPolygonTest : public ProgramTest {
 protected:
  std::vector<std::string> BakeWords(const std::string& out) {
    return {"bake",       scene_,         "--every-polygon",       "--samples",
            "16",         "--rect-light", "-1 6 -1 2 0 0 0 0 2 5", "--out",
            folder_ / out};
  }
};

TEST_F(EveryPolygonTest, ReceiversListsTheLargestFirst) {
  const Finished all = Run({"receivers", scene_, "--json"});
  ASSERT_EQ(all.exit_status, 0) << all.err;
  const Json list = Json::parse(all.out)["receivers"];
  ASSERT_EQ(list.size(), 7u) << "six sides of a box and a wall";
  EXPECT_EQ(list[0]["instance"], "wall");
  EXPECT_NEAR(list[0]["area_m2"].get<double>(), 12, 1e-4);
  EXPECT_EQ(list[0]["width"].get<int>() * list[0]["height"].get<int>(), 256 * 128)
      << "6 by 2 m, the longer side with 256 texels";
  EXPECT_NEAR(std::abs(list[0]["normal"][2].get<double>()), 1, 1e-6);
  for (size_t i = 1; i < 7; ++i) {
    EXPECT_EQ(list[i]["instance"], "box");
    EXPECT_NEAR(list[i]["area_m2"].get<double>(), 4, 1e-4);
    EXPECT_EQ(list[i]["width"], 128);
  }
  const Finished few = Run({"receivers", scene_, "--min-area", "5", "--texels-per-metre", "10"});
  ASSERT_EQ(few.exit_status, 0) << few.err;
  EXPECT_THAT(few.out, ::testing::StartsWith("surface.wall."));
  EXPECT_THAT(few.out, HasSubstr("64"));
  EXPECT_EQ(std::count(few.out.begin(), few.out.end(), '\n'), 1);
  EXPECT_EQ(Run({"receivers", scene_, "--min-area", "-1"}).exit_status, 2);
}

TEST_F(EveryPolygonTest, BakeWritesATextureSetEachHereAndByAServer) {
  const Finished here = Run(BakeWords("here"));
  ASSERT_EQ(here.exit_status, 0) << here.err;
  const Json summary = ReadJson(folder_ / "here/summary.json");
  ASSERT_EQ(summary["baked"].size(), 7u);
  std::vector<std::string> words = BakeWords("there");
  words.insert(words.end(), {"--server", StartServer()});
  const Finished there = Run(words);
  ASSERT_EQ(there.exit_status, 0) << there.err;
  bool has_shadow = false;
  for (const Json& baked : summary["baked"]) {
    const std::string name = baked["name"];
    EXPECT_EQ(baked["inside_texels"].get<int>(),
              baked["width"].get<int>() * baked["height"].get<int>());
    has_shadow = has_shadow || baked["visible_percent"].get<double>() < 99;
    const auto a = ReadImage(folder_ / "here" / (name + ".exr"));
    const auto b = ReadImage(folder_ / "there" / (name + ".exr"));
    ASSERT_TRUE(a.ok() && b.ok()) << name;
    EXPECT_EQ(a->values, b->values) << name;
    EXPECT_EQ(a->values.count("inside"), 1u);
    EXPECT_TRUE(std::filesystem::exists(folder_ / "here" / (name + ".png")));
  }
  EXPECT_TRUE(has_shadow);
}

TEST_F(EveryPolygonTest, TexelsOutsideATriangleAreMarkedInTheFile) {
  std::ofstream(folder_ / "roof.obj") << "o roof\nv 0 0 0\nv 4 0 0\nv 0 0 -4\nf 1 2 3\n";
  const Finished bake = Run({"bake", folder_ / "roof.obj", "--every-polygon", "--sun", "0 1 0 1",
                             "--out", folder_ / "out", "--json"});
  ASSERT_EQ(bake.exit_status, 0) << bake.err;
  const Json baked = Json::parse(bake.out)["baked"];
  ASSERT_EQ(baked.size(), 1u);
  const auto exr = ReadImage(folder_ / "out" / (baked[0]["name"].get<std::string>() + ".exr"));
  ASSERT_TRUE(exr.ok());
  double inside = 0;
  for (const float x : exr->values.at("inside")) inside += x;
  EXPECT_EQ(inside, baked[0]["inside_texels"].get<double>());
  EXPECT_NEAR(inside / (exr->width * exr->height), 0.5, 0.02);
}

TEST_F(EveryPolygonTest, ViewDrawsThem) {
  const Finished view = Run({"view", scene_, "--every-polygon", "--samples", "8", "--size", "80x60",
                             "--out", folder_ / "view.png", "--json"});
  ASSERT_EQ(view.exit_status, 0) << view.err;
  EXPECT_EQ(Json::parse(view.out)["shadows"], 7);
}

TEST_F(EveryPolygonTest, NoSurfaceIsOneLineOfError) {
  const Finished bake =
      Run({"bake", scene_, "--every-polygon", "--min-area", "1000", "--out", folder_ / "out"});
  EXPECT_NE(bake.exit_status, 0);
  EXPECT_THAT(bake.err, HasSubstr("--every-polygon: found no planar surface"));
}

}  // namespace
}  // namespace penumbra::testing
