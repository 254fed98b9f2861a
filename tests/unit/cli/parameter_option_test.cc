#include "client/cli/parameter_option.h"

#include <gtest/gtest.h>

#include <string>

#include "client/cli/command_line.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

absl::StatusOr<TechniqueParams> Baked(std::vector<std::string> options) {
  std::vector<std::string> words = {"bake", "a.glb", "--out", "dir"};
  words.insert(words.end(), options.begin(), options.end());
  const auto command = ParseCommandLine(words);
  if (!command.ok()) return command.status();
  return std::get<BakeCommand>(*command).request.params;
}

// A value of the parameter's type that is not its default.
std::string OtherValue(const ParameterInfo& parameter) {
  if (parameter.type == "bool") return parameter.default_value == "true" ? "false" : "true";
  if (parameter.type == "rgb") return "0.5";
  if (parameter.type == "enum") {
    const std::string range(parameter.range);
    const std::string last = range.substr(range.rfind(' ') + 1);
    return last == parameter.default_value ? range.substr(0, range.find_first_of(" ,")) : last;
  }
  return "7";
}

TEST(ParameterOption, SetsEveryParameterOfEveryTechnique) {
  for (const TechniqueParams& defaults : AllTechniques()) {
    const TechniqueInfo& info = InfoOf(defaults);
    for (const ParameterInfo& parameter : info.parameters) {
      if (parameter.name == "form_factor_error") continue;  // 7 is out of its range
      const std::string text = std::string(parameter.name) + "=" + OtherValue(parameter);
      // Whichever comes first on the line.
      const auto params = Baked({"--set", text, "--technique", std::string(info.name)});
      ASSERT_TRUE(params.ok()) << info.name << " " << text << ": " << params.status();
      EXPECT_NE(*params, defaults) << info.name << " " << text;
    }
  }
}

TEST(ParameterOption, SaysWhatIsWrong) {
  const auto fault = [](const std::string& technique, const std::string& text) {
    return ErrorReason(Baked({"--technique", technique, "--set", text}).status());
  };
  EXPECT_EQ(fault("layered_attenuation", "resolution"), "FORMAT");
  EXPECT_EQ(fault("layered_attenuation", "resolution=many"), "RANGE");
  EXPECT_EQ(fault("layered_attenuation", "key_views=1"), "RANGE");
  EXPECT_EQ(fault("layered_attenuation", "source=magic"), "RANGE");
  EXPECT_EQ(fault("layered_attenuation", "backend=triangles"), "UNKNOWN_PARAMETER");
  EXPECT_EQ(fault("coherent_raytrace", "gap_bias=1 2"), "RANGE");
  EXPECT_EQ(fault("soft_texture", "resolution=3"), "UNKNOWN_PARAMETER");
  const auto status = Baked({"--technique", "coherent_raytrace", "--set", "samples=lots"}).status();
  EXPECT_EQ(status.message(), "--set samples: found \"lots\", need a whole number");
}

TEST(ParameterOption, AFinalPictureHasItsOwn) {
  const auto viewed = [](std::vector<std::string> options) {
    std::vector<std::string> words = {"view",  "a.glb",       "--out",
                                      "a.png", "--technique", "layered_attenuation"};
    words.insert(words.end(), options.begin(), options.end());
    return ParseCommandLine(words);
  };
  const auto command = viewed({"--final", "--samples", "16", "--seed", "5", "--set",
                               "resolution=300", "--final-set", "backend=depth_images"});
  ASSERT_TRUE(command.ok()) << command.status();
  const auto& view = std::get<ViewCommand>(*command);
  LayeredAttenuationParams first{.samples = 16, .seed = 5};
  first.resolution = 300;
  EXPECT_EQ(view.request.params, TechniqueParams(first));
  CoherentRaytraceParams final{.samples = 16, .seed = 5};
  final.backend = RayBackend::kDepthImages;
  final.output = RadianceFormat::kFloat32;
  EXPECT_EQ(view.final_params, TechniqueParams(final));
  EXPECT_FALSE(viewed({"--final-set", "seed=2"}).ok()) << "without --final";
  EXPECT_EQ(ErrorFieldPath(viewed({"--final", "--final-set", "seed=x"}).status()),
            "--final-set seed");
}

TEST(ParameterOption, OptionsOfSoftTextureAreItsAlone) {
  for (const char* option : {"--method", "--shading", "--output"}) {
    const std::string value = std::string(option) == "--method"    ? "silhouette"
                              : std::string(option) == "--shading" ? "product"
                                                                   : "half";
    const auto status = Baked({"--technique", "layered_attenuation", option, value}).status();
    EXPECT_EQ(ErrorReason(status), "CONFLICT") << status;
    EXPECT_EQ(ErrorFieldPath(status), option);
  }
}

}  // namespace
}  // namespace penumbra
