// Depth maps as tests want them: all at once, of views that a scene's light has.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "render/light_view/depth_source.h"
#include "render/light_view/view_fit.h"
#include "render/scene/light_sample.h"
#include "tests/support/nearest_depth.h"

namespace penumbra::testing {

// The views' maps, which come in their order.
inline std::vector<DepthMap> DrawAll(DepthSource& source, std::span<const LightView> views) {
  std::vector<DepthMap> maps;
  const auto status = source.Draw(views, {}, [&](size_t index, DepthMap map) {
    EXPECT_EQ(index, maps.size());
    maps.push_back(std::move(map));
    return absl::OkStatus();
  });
  EXPECT_TRUE(status.ok()) << status;
  return maps;
}

// Views of all faces from two samples of the scene's "light", `side` pixels along the longer side.
inline std::vector<LightView> SampledViews(const Scene& scene, uint64_t seed, double side) {
  const auto light = scene.FindLight("light");
  const auto boxes = CasterBoxes(scene);
  std::vector<LightView> views;
  for (const LightFace& face : FacesOf(*light, scene.Bounds())) {
    const double pitch = std::max(face.window.size().x, face.window.size().y) / side;
    for (const LightSample& sample : SampleLight(*light, 2, seed, scene.Bounds().center())) {
      if (const auto view = ViewFrom(face, sample, boxes, pitch)) views.push_back(*view);
    }
  }
  return views;
}

}  // namespace penumbra::testing
