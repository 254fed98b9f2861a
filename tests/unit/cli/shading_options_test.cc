#include "client/cli/shading_options.h"

#include <gtest/gtest.h>

#include <string>

#include "client/cli/command_line.h"

namespace penumbra {
namespace {

absl::StatusOr<SoftTextureParams> Baked(std::vector<std::string> options) {
  std::vector<std::string> words = {"bake", "a.glb", "--out", "dir"};
  words.insert(words.end(), options.begin(), options.end());
  const auto command = ParseCommandLine(words);
  if (!command.ok()) return command.status();
  return std::get<SoftTextureParams>(std::get<BakeCommand>(*command).request.params);
}

TEST(ShadingOptions, SetWhatTheySay) {
  const auto params =
      Baked({"--shading", "sample_sum", "--form-factor-error", "0.01", "--ambient-radiance",
             "0.1,0.2,0.3", "--output", "unorm8", "--output-scale", "4", "--count-bits", "16",
             "--silhouette-reuse", "8"});
  ASSERT_TRUE(params.ok()) << params.status();
  EXPECT_EQ(params->shading, Shading::kSampleSum);
  EXPECT_EQ(params->form_factor_error, 0.01f);
  EXPECT_EQ(params->ambient, Vec3(0.1f, 0.2f, 0.3f));
  EXPECT_EQ(params->output, RadianceFormat::kUnorm8);
  EXPECT_EQ(params->output_scale, 4);
  EXPECT_EQ(params->count_bits, CountBits::k16);
  EXPECT_EQ(params->silhouette_reuse, 8u);
  EXPECT_TRUE(params->radiance);
  EXPECT_EQ(*Baked({}), SoftTextureParams{});
  EXPECT_FALSE(Baked({"--count-bits", "8"})->radiance);
}

TEST(ShadingOptions, NameThemselvesInErrors) {
  for (const ShadingOption& option : ShadingOptions()) {
    const auto status = Baked({option.name, "nonsense"}).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << option.name;
    EXPECT_EQ(std::string(status.message()).find(option.name), 0u) << status.message();
  }
  EXPECT_FALSE(Baked({"--form-factor-error", "0.2"}).ok());
  EXPECT_FALSE(Baked({"--ambient-radiance", "1,2"}).ok());
  for (const char* reuse : {"0", "1.5", "65", "-1"}) {
    EXPECT_FALSE(Baked({"--silhouette-reuse", reuse}).ok()) << reuse;
  }
}

}  // namespace
}  // namespace penumbra
