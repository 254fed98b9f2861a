#include "client/cli/fitting_options.h"

#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "render/scene/field_error.h"

namespace penumbra {
namespace {

// What is asked for by one option, and the targets that have a use for it.
struct OptionCase {
  std::string option;
  std::function<void(ShadowRequest&)> give;
  bool receivers, scene, points;
};

const OptionCase kCases[] = {
    {"--receiver", [](auto& r) { r.receivers = {Parallelogram{}}; }, true, false, false},
    {"--receiver-instance", [](auto& r) { r.receiver_instances = {"a"}; }, true, false, false},
    {"--every-polygon", [](auto& r) { r.every_polygon = true; }, true, false, false},
    {"--floor", [](auto& r) { r.floor = true; }, true, true, true},
    {"--size",
     [](auto& r) {
       r.texels = GridSize{8, 8};
     },
     true, false, false},
    {"--lightmap", [](auto& r) { r.points.lightmaps = {"a"}; }, false, false, true},
    {"--points", [](auto& r) { r.points.file = "a.txt"; }, false, false, true},
    {"--camera", [](auto& r) { r.points.camera = Camera{}; }, false, false, true},
    {"--picture",
     [](auto& r) {
       r.points.picture = GridSize{8, 8};
     },
     false, false, true},
    {"--crop",
     [](auto& r) {
       r.points.crop = {0, 0, 1, 1};
     },
     false, false, true},
    {"--first",
     [](auto& r) {
       r.points.first = {0, 0, 1, 1};
     },
     false, false, true},
};

TEST(FittingOptions, EachOptionIsOfTheTechniquesThatHaveAUseForIt) {
  for (const TechniqueParams& params : AllTechniques()) {
    const TechniqueInfo& info = InfoOf(params);
    for (const OptionCase& one : kCases) {
      ShadowRequest request;
      request.params = params;
      EXPECT_TRUE(CheckOptionsFit(request).ok()) << info.name;
      one.give(request);
      const bool fits = info.target == SpecTarget::kReceiver ? one.receivers
                        : info.target == SpecTarget::kScene  ? one.scene
                                                             : one.points;
      const absl::Status status = CheckOptionsFit(request);
      EXPECT_EQ(status.ok(), fits) << info.name << " " << one.option << ": " << status;
      if (fits) continue;
      EXPECT_EQ(ErrorReason(status), "CONFLICT");
      EXPECT_EQ(ErrorFieldPath(status), one.option);
    }
  }
}

void ExpectConflict(const absl::Status& status, const std::string& option,
                    const std::string& other) {
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << option << " " << other;
  EXPECT_EQ(ErrorReason(status), "CONFLICT");
  EXPECT_EQ(ErrorFieldPath(status), option);
  EXPECT_NE(status.message().find(other), std::string::npos) << status;
}

TEST(FittingOptions, TracedPicturesHaveAllFaces) {
  ViewCommand command;
  command.culls_back_faces = true;
  EXPECT_TRUE(CheckOptionsFit(command).ok());
  command.final = true;
  ExpectConflict(CheckOptionsFit(command), "--cull-back-faces", "--final");
  command.final = false;
  command.request.params = CoherentRaytraceParams{};
  ExpectConflict(CheckOptionsFit(command), "--cull-back-faces", "--technique coherent_raytrace");
}

TEST(FittingOptions, OnlyCompositedShadowsHaveAnOpacity) {
  ViewCommand command;
  command.request.params = ShadowVolumeParams{};
  command.volume_look = VolumeLook{};
  command.has_volume_opacity = true;
  ExpectConflict(CheckOptionsFit(command), "--volume-opacity", "--volume-shading ambient");
  command.volume_look->shading = VolumeShading::kBlack;
  ExpectConflict(CheckOptionsFit(command), "--volume-opacity", "--volume-shading black");
  command.volume_look->shading = VolumeShading::kComposited;
  EXPECT_TRUE(CheckOptionsFit(command).ok());
}

TEST(FittingOptions, OnlyTexturesAddUpLights) {
  for (const TechniqueParams& params : AllTechniques()) {
    ShadowRequest request;
    request.params = params;
    request.light_ids = {"*"};
    EXPECT_TRUE(CheckOptionsFit(request).ok()) << "one of each";
    request.adds_up_lights = true;
    if (std::holds_alternative<SoftTextureParams>(params)) {
      EXPECT_TRUE(CheckOptionsFit(request).ok());
    } else {
      ExpectConflict(CheckOptionsFit(request), "--light", "one light at a time");
      ExpectConflict(CheckLightsFit({"*"}, params), "--light", std::string(InfoOf(params).name));
    }
  }
}

TEST(FittingOptions, ALightmapHasTexels) {
  ShadowRequest request;
  request.params = CoherentRaytraceParams{};
  request.points.lightmaps = {"a"};
  request.texels = GridSize{8, 8};
  EXPECT_TRUE(CheckOptionsFit(request).ok());
}

}  // namespace
}  // namespace penumbra
