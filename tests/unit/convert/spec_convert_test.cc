#include "proto/convert/spec_convert.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <string>

#include "absl/strings/ascii.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

TEST(SpecConvertTest, EveryTechniqueGoesThereAndBack) {
  for (const TechniqueParams& params : AllTechniques()) {
    ArtifactSpec spec{.params = params, .light_id = "l"};
    if (InfoOf(params).target == SpecTarget::kReceiver) spec.receiver_id = "r";
    if (InfoOf(params).target == SpecTarget::kPoints) spec.points = LightmapTexels{"i", 4, 5};
    EXPECT_EQ(*TargetOf(ToProto(spec)), InfoOf(params).target);
    const auto back = FromProto(ToProto(spec));
    ASSERT_TRUE(back.ok()) << back.status();
    EXPECT_EQ(*back, spec);
  }
  const ArtifactSpec spec{
      .params = SoftTextureParams{.samples = 3, .seed = ~uint64_t{0}, .radiance = true},
      .light_id = "l",
      .receiver_id = "r",
      .time_budget_ms = 33};
  EXPECT_EQ(*FromProto(ToProto(spec)), spec);
  for (const std::string_view name : kVisibilityMethodNames) {
    ArtifactSpec by_method = spec;
    std::get<SoftTextureParams>(by_method.params).method = *VisibilityMethodNamed(name);
    EXPECT_EQ(*FromProto(ToProto(by_method)), by_method);
    EXPECT_EQ(v1::VisibilityMethod_Name(ToProto(by_method).soft_texture().method()),
              "VISIBILITY_METHOD_" + absl::AsciiStrToUpper({name.data(), name.size()}));
  }
}

TEST(SpecConvertTest, EveryParameterGoesThereAndBackAndIsPartOfTheKey) {
  using Layered = LayeredAttenuationParams;
  using Coherent = CoherentRaytraceParams;
  const TechniqueParams layered[] = {Layered{},
                                     Layered{.samples = 3},
                                     Layered{.seed = 3},
                                     Layered{.resolution = 300},
                                     Layered{.tolerance = 0.5f},
                                     Layered{.source = DepthMethod::kGl},
                                     Layered{.key_views = true},
                                     Layered{.max_layers = 3}};
  const TechniqueParams coherent[] = {Coherent{},
                                      Coherent{.samples = 3},
                                      Coherent{.seed = 3},
                                      Coherent{.backend = RayBackend::kDepthImages},
                                      Coherent{.radiance = false},
                                      Coherent{.output = RadianceFormat::kFloat32},
                                      Coherent{.coherence = false},
                                      Coherent{.whole_light = false},
                                      Coherent{.ray_accelerations = false},
                                      Coherent{.prediction_distance = 0.5f},
                                      Coherent{.resolution = 300},
                                      Coherent{.gap_bias = 0.5f},
                                      Coherent{.shadow_bias = 0.5f}};
  std::set<std::string> keys;
  const auto check = [&](const ArtifactSpec& spec) {
    const auto back = FromProto(ToProto(spec));
    ASSERT_TRUE(back.ok()) << back.status();
    EXPECT_EQ(*back, spec);
    EXPECT_TRUE(keys.insert(SpecKey(spec)).second) << SpecKey(spec);
  };
  for (const TechniqueParams& params : layered) check({.params = params, .light_id = "l"});
  for (const TechniqueParams& params : coherent) {
    check({.params = params, .light_id = "l", .points = LightmapTexels{"i", 4, 5}});
  }
  check({.params = Coherent{}, .light_id = "l", .points = LightmapTexels{"i", 4, 6}});
}

TEST(SpecConvertTest, ShadingGoesThereAndBack) {
  for (size_t i = 0; i < 4; ++i) {
    const ArtifactSpec spec{
        .params = SoftTextureParams{.radiance = true,
                                    .silhouette_reuse = static_cast<uint32_t>(1 + i),
                                    .shading = static_cast<Shading>(i % 2),
                                    .form_factor_error = 0.25f * i,
                                    .ambient = Vec3(0.1f * i, 2, 3),
                                    .output = static_cast<RadianceFormat>(i),
                                    .output_scale = 1.5f * i,
                                    .count_bits = static_cast<CountBits>(i % 3)},
        .light_id = "l",
        .receiver_id = "r"};
    const auto proto = ToProto(spec);
    EXPECT_EQ(*FromProto(proto), spec);
    EXPECT_EQ(v1::RadianceFormat_Name(proto.soft_texture().output()),
              "RADIANCE_FORMAT_" + absl::AsciiStrToUpper({kRadianceFormatNames[i].data(),
                                                          kRadianceFormatNames[i].size()}));
  }
}

// Artifacts that differ in any of it are different artifacts.
TEST(SpecConvertTest, ShadingIsPartOfTheKey) {
  const ArtifactSpec plain{.params = SoftTextureParams{}, .light_id = "l", .receiver_id = "r"};
  const SoftTextureParams others[] = {
      {.silhouette_reuse = 2},           {.shading = Shading::kSampleSum},
      {.form_factor_error = 1.0001e-3f}, {.ambient = Vec3(0, 0, 1e-7f)},
      {.output = RadianceFormat::kHalf}, {.output_scale = 1},
      {.count_bits = CountBits::k16}};
  for (const SoftTextureParams& params : others) {
    EXPECT_NE(SpecKey({params, "l", "r"}), SpecKey(plain));
  }
}

TEST(SpecConvertTest, UnknownShadingIsRefused) {
  v1::ArtifactSpec proto;
  proto.mutable_soft_texture()->set_shading(static_cast<v1::Shading>(99));
  EXPECT_EQ(ErrorFieldPath(FromProto(proto).status()), "spec.soft_texture.shading");
  proto.mutable_soft_texture()->set_shading(v1::SHADING_PRODUCT);
  proto.mutable_soft_texture()->set_output(static_cast<v1::RadianceFormat>(-1));
  EXPECT_EQ(ErrorFieldPath(FromProto(proto).status()), "spec.soft_texture.output");
}

TEST(SpecConvertTest, AnUnknownMethodIsRefused) {
  v1::ArtifactSpec proto;
  proto.mutable_soft_texture()->set_method(static_cast<v1::VisibilityMethod>(99));
  EXPECT_EQ(ErrorFieldPath(FromProto(proto).status()), "spec.soft_texture.method");
}

TEST(SpecConvertTest, ATimeBudgetThatIsNoTimeIsRefused) {
  ArtifactSpec spec{.params = SoftTextureParams{}, .light_id = "l", .receiver_id = "r"};
  spec.time_budget_ms = -1;
  EXPECT_EQ(ErrorFieldPath(FromProto(ToProto(spec)).status()), "spec.time_budget_ms");
}

TEST(SpecConvertTest, AbsentParametersAreTheDefaults) {
  v1::ArtifactSpec proto;
  proto.mutable_soft_texture();
  proto.set_light_id("l");
  proto.set_receiver_id("r");
  EXPECT_EQ(FromProto(proto)->params, TechniqueParams(SoftTextureParams{}));
}

TEST(SpecConvertTest, NoTechniqueIsAnErrorThatNamesThem) {
  const auto status = FromProto(v1::ArtifactSpec()).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(ErrorReason(status), "UNKNOWN_TECHNIQUE");
  EXPECT_THAT(std::string(status.message()), ::testing::HasSubstr("soft_texture"));
}

TEST(SpecConvertTest, IdsThatNoObjectCanHaveAreRefused) {
  const ArtifactSpec good{.params = SoftTextureParams{}, .light_id = "l", .receiver_id = "r"};
  for (const std::string& bad : {std::string(), std::string(900'000, 'x'), std::string("a b")}) {
    ArtifactSpec spec = good;
    spec.light_id = bad;
    auto status = FromProto(ToProto(spec)).status();
    EXPECT_EQ(ErrorReason(status), "BAD_ID");
    EXPECT_EQ(ErrorFieldPath(status), "spec.light_id");
    spec = good;
    spec.receiver_id = bad;
    status = FromProto(ToProto(spec)).status();
    EXPECT_EQ(ErrorReason(status), "BAD_ID");
    EXPECT_EQ(ErrorFieldPath(status), "spec.receiver_id");
  }
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
