// Updating a texture after an edit by drawing what moved over the kept shadows of what stayed.
//
//   EditPlan plan = PlanEdit(memory, subject, scene);
//   if (plan.base) …  // draw plan.base->moving over the base, once that is drawn far enough
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "render/scene/area_light.h"
#include "render/scene/light_sample.h"
#include "render/scene/receiver.h"
#include "render/scene/scene.h"
#include "render/technique/soft_texture/bit_counters.h"
#include "render/technique/soft_texture/shadow_bitmap.h"
#include "render/technique/soft_texture/soft_texture_params.h"
#include "render/technique/technique_memory.h"

namespace penumbra {

// The hard shadow of each of n samples, one bit a texel, packed as in ShadowBitmap without padding.
class SampleShadows {
 public:
  SampleShadows(uint32_t width, uint32_t height, uint32_t samples)
      : width_(width),
        columns_((width + 31) / 32),
        height_(height),
        words_(size_t{columns_} * height * samples, 0u) {}

  static size_t Bytes(uint32_t width, uint32_t height, uint32_t samples) {
    return sizeof(uint32_t) * ((width + 31) / 32) * size_t{height} * samples;
  }

  // Copies what `bitmap`, whose first row is row `first_row` of the texture, has touched.
  void Store(uint32_t sample, uint32_t first_row, const ShadowBitmap& bitmap);
  // Clears the bits of `bitmap` that are set here.
  void Subtract(uint32_t sample, uint32_t first_row, ShadowBitmap& bitmap) const;

  // Takes one off a texel's count for each of the first `samples` shadows that hides it.
  //
  // Shapes  H·W counts, row by row
  void SubtractFrom(std::vector<uint16_t>& counts, uint32_t samples) const;

  // The words of a row: those of the next column and of the next sample lie a stride further.
  const uint32_t* Row(uint32_t sample, uint32_t row) const { return &words_[At(sample, 0, row)]; }
  size_t column_stride() const { return height_; }
  size_t sample_stride() const { return size_t{columns_} * height_; }

 private:
  size_t At(uint32_t sample, uint32_t column, uint32_t row) const {
    return (size_t{sample} * columns_ + column) * height_ + row;
  }

  uint32_t width_, columns_, height_;
  std::vector<uint32_t> words_;
};

// All that decides over a texture besides the occluders.
struct ShadowSubject {
  ReceiverPatch receiver;
  AreaLight light;
  SoftTextureParams params;

  friend bool operator==(const ShadowSubject&, const ShadowSubject&) = default;
};

// The shadows of all that stays, in the order of the samples. A computation that is stopped leaves
// what it has drawn to the next one.
struct ShadowBase {
  std::set<std::string> moving;  // left out
  MemoryBudget::Lease lease;
  SampleShadows shadows;
  uint32_t drawn = 0;            // samples
  std::vector<uint16_t> counts;  // H·W: all samples, less those drawn that are hidden
  std::vector<LightSample> samples;
  BitmapCounters counters;                // with which what moves is counted
  std::optional<double> borrowing_error;  // of what stays, once all is drawn
};

struct EditPlan {
  std::shared_ptr<ShadowBase> base;  // null: draw everything, keep nothing
  uint64_t moving_triangles = 0;
};

// How to compute `subject` on `scene`, given what `memory` kept of the scenes before; it then keeps
// this one.
//
// An instance that differs from the last scene's is taken to go on moving: the base is everything
// else. A new one is begun when something of it changes, at the cost of computing without it.
// Scenes, and with them their meshes, are not held on to.
EditPlan PlanEdit(TechniqueMemory& memory, const ShadowSubject& subject, const Scene& scene);

}  // namespace penumbra
