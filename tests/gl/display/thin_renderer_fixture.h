// A thin renderer on the software device, and a view that makes its pixels easy to name.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "client/display/thin_renderer.h"
#include "tests/gl/display/small_scenes.h"
#include "tests/gl/display/software_context.h"

namespace penumbra {

// Looks along −z at the square [−1, 1]² in the plane z = 0, which fills the picture.
inline const Camera kFront = {
    .eye = {0, 0, 5}, .target = {0, 0, 0}, .up = {0, 1, 0}, .fov_y_deg = 22.6198649f};
inline const RenderOptions kSquare = {
    .width = 64, .height = 64, .samples_per_side = 1, .ambient = Vec3(1), .draws_lights = true};

inline Instance Card(const std::string& id, Vec3 color, float z = 0, float half = 1) {
  return {.id = id,
          .mesh = Quad({-half, -half, z}, {2 * half, 0, 0}, {0, 2 * half, 0}),
          .color = color};
}

class ThinRendererTest : public SoftwareContextTest {
 protected:
  void SetUp() override {
    SoftwareContextTest::SetUp();
    auto renderer = ThinRenderer::Create(*context_);
    ASSERT_TRUE(renderer.ok()) << renderer.status();
    renderer_ = *std::move(renderer);
  }

  Picture Render(const SceneDelta& delta, const RenderOptions& options = kSquare,
                 const Camera& camera = kFront) {
    const auto picture = renderer_->Render(*context_, *SceneOf(delta), {}, camera, options);
    EXPECT_TRUE(picture.ok()) << picture.status();
    return picture.ok() ? *picture
                        : Picture{.width = 64, .height = 64, .pixels = std::vector<Vec4>(64 * 64)};
  }

  absl::Status Refusal(const Camera& camera, const RenderOptions& options) {
    return renderer_->Render(*context_, *SceneOf({}), {}, camera, options).status();
  }

  std::unique_ptr<ThinRenderer> renderer_;
};

}  // namespace penumbra
