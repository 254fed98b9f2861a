#include "proto/convert/spec_convert.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/scene/field_error.h"

namespace penumbra {
namespace {

TEST(SpecConvertTest, EveryTechniqueGoesThereAndBack) {
  for (const TechniqueParams& params : AllTechniques()) {
    const ArtifactSpec spec{.params = params, .light_id = "l", .receiver_id = "r"};
    const auto back = FromProto(ToProto(spec));
    ASSERT_TRUE(back.ok()) << back.status();
    EXPECT_EQ(*back, spec);
  }
  const ArtifactSpec spec{
      .params = SoftTextureParams{.samples = 3, .seed = ~uint64_t{0}, .radiance = true},
      .light_id = "l",
      .receiver_id = "r"};
  EXPECT_EQ(*FromProto(ToProto(spec)), spec);
}

TEST(SpecConvertTest, AbsentParametersAreTheDefaults) {
  v1::ArtifactSpec proto;
  proto.mutable_soft_texture();
  EXPECT_EQ(FromProto(proto)->params, TechniqueParams(SoftTextureParams{}));
}

TEST(SpecConvertTest, NoTechniqueIsAnErrorThatNamesThem) {
  const auto status = FromProto(v1::ArtifactSpec()).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(ErrorReason(status), "UNKNOWN_TECHNIQUE");
  EXPECT_THAT(std::string(status.message()), ::testing::HasSubstr("soft_texture"));
}

TEST(SpecConvertTest, TechniquesAreDescribedWhole) {
  const auto infos = AllTechniqueInfos();
  ASSERT_EQ(infos.size(), AllTechniques().size());
  EXPECT_EQ(infos[0].name(), SoftTextureParams::kInfo.name);
  EXPECT_EQ(static_cast<size_t>(infos[0].parameters_size()),
            SoftTextureParams::kInfo.parameters.size());
  // The protocol's own field names are the parameters' names.
  for (const auto& parameter : infos[0].parameters()) {
    EXPECT_NE(v1::SoftTextureParameters::descriptor()->FindFieldByName(parameter.name()), nullptr);
  }
}

}  // namespace
}  // namespace penumbra
