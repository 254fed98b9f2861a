// Updating a texture after an edit by drawing what moved over the kept shadows of what stayed.
//
//   ShadowPlan plan = PlanShadows(memory, subject, scene);
//   if (plan.base) …  // draw plan.base->moving over the base, which may have to be drawn first
#pragma once

#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "render/scene/area_light.h"
#include "render/scene/light_sample.h"
#include "render/scene/receiver.h"
#include "render/scene/scene.h"
#include "render/technique/soft_texture/shadow_bitmap.h"
#include "render/technique/soft_texture/soft_texture_params.h"
#include "render/technique/technique_memory.h"

namespace penumbra {

// The hard shadow of each of n samples, one bit a texel, packed as in ShadowBitmap without padding.
class SampleShadows {
 public:
  SampleShadows(uint32_t width, uint32_t height, uint32_t samples)
      : columns_((width + 31) / 32),
        height_(height),
        words_(size_t{columns_} * height * samples, 0u) {}

  static size_t Bytes(uint32_t width, uint32_t height, uint32_t samples) {
    return sizeof(uint32_t) * ((width + 31) / 32) * size_t{height} * samples;
  }

  // Copies what `bitmap`, whose first row is row `first_row` of the texture, has touched.
  void Store(uint32_t sample, uint32_t first_row, const ShadowBitmap& bitmap);
  // Clears the bits of `bitmap` that are set here.
  void Subtract(uint32_t sample, uint32_t first_row, ShadowBitmap& bitmap) const;

 private:
  size_t At(uint32_t sample, uint32_t column, uint32_t row) const {
    return (size_t{sample} * columns_ + column) * height_ + row;
  }

  uint32_t columns_, height_;
  std::vector<uint32_t> words_;
};

// All that decides over a texture besides the occluders.
struct ShadowSubject {
  ReceiverPatch receiver;
  AreaLight light;
  SoftTextureParams params;

  friend bool operator==(const ShadowSubject&, const ShadowSubject&) = default;
};

// What is drawn and what is taken as it is.
struct ShadowBase {
  using Instances = std::shared_ptr<const Scene::Table<Instance>>;

  ShadowSubject subject;
  std::set<std::string> moving;  // left out of the base
  Instances instances;           // of the scene that the base was drawn from
  MemoryBudget::Lease lease;
  SampleShadows shadows;
  std::vector<uint16_t> counts;  // samples hidden by the base; empty until it is drawn
  std::vector<LightSample> samples;
};

struct ShadowPlan {
  std::shared_ptr<ShadowBase> base;  // null: draw everything, keep nothing
  bool base_is_drawn = false;        // otherwise draw it first
};

// How to compute `subject` on `scene`, given what `memory` kept of the scenes before; it then keeps
// this one.
//
// An instance that differs from the last scene's is taken to go on moving: the base is everything
// else. It is drawn anew when something of it changes, at the cost of computing without it.
ShadowPlan PlanShadows(TechniqueMemory& memory, const ShadowSubject& subject, const Scene& scene);

}  // namespace penumbra
