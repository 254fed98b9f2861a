// Final pictures from the command line.
#include <gmock/gmock.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>

#include "client/display/image_io.h"
#include "client/display/tone.h"
#include "tests/integration/cli/run_program.h"

namespace penumbra::testing {
namespace {

using Json = nlohmann::json;

class FinalPictureCommandTest : public ProgramTest {
 protected:
  // The picture's bytes.
  std::string View(const std::vector<std::string>& options) {
    const std::string path = folder_ / "view.png";
    std::vector<std::string> words = {"view",
                                      scene_,
                                      "--floor",
                                      "--size",
                                      "64x48",
                                      "--out",
                                      path,
                                      "--rect-light",
                                      "-1 6 -1 2 0 0 0 0 2 5",
                                      "--exposure",
                                      "1"};
    words.insert(words.end(), options.begin(), options.end());
    const Finished run = Run(words);
    EXPECT_EQ(run.exit_status, 0) << run.err;
    return ReadText(path);
  }
};

TEST_F(FinalPictureCommandTest, HasOptionsOfItsOwn) {
  const std::vector<std::string> preview = {
      "--technique", "layered_attenuation", "--set",  "resolution=64",
      "--set",       "samples=4",           "--final"};
  const auto with = [&](const std::string& option) {
    std::vector<std::string> words = preview;
    words.insert(words.end(), {"--final-set", option});
    return View(words);
  };
  const std::string coarse = with("samples=1");
  EXPECT_NE(coarse, with("samples=64"));
  EXPECT_EQ(coarse, View({"--technique", "coherent_raytrace", "--samples", "1"}));
}

TEST_F(FinalPictureCommandTest, IsBakedAsAViewIsExposed) {
  const Finished bake = Run({"bake", scene_, "--technique", "coherent_raytrace", "--samples", "4",
                             "--picture", "64x48", "--camera", "6 7 9, 0 3 0, 60", "--floor",
                             "--point-light", "2 0.15 2 5", "--out", folder_ / "out"});
  ASSERT_EQ(bake.exit_status, 0) << bake.err;
  const Json json = Json::parse(ReadText(folder_ / "out/picture.json"));
  const double exposure = json["png"]["exposure"];
  const auto numbers = ReadImage(folder_ / "out/picture.exr");
  const auto png = ReadImage(folder_ / "out/picture.png");
  ASSERT_TRUE(numbers.ok() && png.ok());
  const auto& inside = numbers->values.at("inside");
  const auto& red = numbers->values.at("R");
  std::vector<float> seen;
  for (size_t i = 0; i < inside.size(); ++i) {
    if (inside[i] == 1) seen.push_back(red[i]);
    if (inside[i] == 0) {
      EXPECT_NEAR(png->values.at("R")[i], SrgbFromLinear(ToneOptions{}.background.x), 0.01f) << i;
    }
  }
  ASSERT_LT(seen.size(), inside.size()) << "all of the picture is surface";
  ASSERT_FALSE(seen.empty());
  std::ranges::sort(seen);
  EXPECT_NEAR(exposure * seen[seen.size() * 9 / 10], 0.6, 0.05);
  EXPECT_LT(1 / exposure, 0.5 * seen.back()) << "the brightest pixel sways it";
}

}  // namespace
}  // namespace penumbra::testing
