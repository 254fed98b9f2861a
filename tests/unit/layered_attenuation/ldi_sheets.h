// A lamp over sheets on which attenuation LDIs are built.
#pragma once

#include <gtest/gtest.h>

#include <memory>

#include "render/technique/layered_attenuation/ldi_passes.h"
#include "tests/unit/layered_attenuation/ldi_of.h"

namespace penumbra::testing {

inline AreaLight Lamp() {
  return {.id = "lamp", .shape = RectangleLight{.corner = {-0.5f, 4, -0.5f}, .two_sided = false}};
}

inline std::shared_ptr<const Scene> Sheets() {
  return SceneOf({Sheet({0, 0, 0}, 3, 3), Sheet({0.5f, 1, 0.2f}, 0.7f, 0.9f),
                  Sheet({-0.2f, 2, 0}, 0.3f, 0.5f)});
}

class LdiPassesTest : public ::testing::Test {
 protected:
  absl::StatusOr<std::unique_ptr<LdiPasses>> Create(const LdiOptions& options) {
    return LdiPasses::Create(*scene_, Lamp(), options, source_, arena_);
  }
  // Of all samples.
  absl::Status Build(const LdiOptions& options) {
    const auto passes = Create(options);
    return passes.ok() ? (*passes)->Advance(1024, {}) : passes.status();
  }

  const std::shared_ptr<const Scene> scene_ = Sheets();
  tbb::task_arena arena_{2};
  RasterDepthSource source_{*scene_, arena_};
};

}  // namespace penumbra::testing
