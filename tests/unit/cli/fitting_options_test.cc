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

TEST(FittingOptions, ALightmapHasTexels) {
  ShadowRequest request;
  request.params = CoherentRaytraceParams{};
  request.points.lightmaps = {"a"};
  request.texels = GridSize{8, 8};
  EXPECT_TRUE(CheckOptionsFit(request).ok());
}

}  // namespace
}  // namespace penumbra
