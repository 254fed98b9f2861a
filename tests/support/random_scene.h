// Scenes with all that can go wrong in them, made from a number.
#pragma once

#include <cstdint>
#include <memory>

#include "render/math/random.h"
#include "render/math/vec.h"
#include "render/scene/scene.h"

namespace penumbra::testing {

// A stream of random numbers with a state, for tests.
class Dice {
 public:
  explicit Dice(uint64_t seed) : seed_(seed) {}

  float Between(float lo, float hi);
  uint32_t Below(uint32_t n);
  Vec3 InCube(float half);  // in [-half, half]³
  Vec3 Direction();         // of length 1
  // Rotated, sheared, stretched, now and then mirrored.
  Affine AnyAffine(float size, Vec3 position);

 private:
  const uint64_t seed_;
  uint64_t index_ = 0;
};

constexpr int kLightKinds = 6;
AreaLight RandomLight(Dice& dice, int kind);

// A light "light" of kind seed % 6 and a receiver "receiver" of any shape and odd size, with boxes,
// single triangles, slivers, spheres, masked sheets and what is degenerate about them: through the
// receiver, in its plane, around the light, mirrored, flattened, of no area, not casting.
std::shared_ptr<const Scene> RandomScene(uint64_t seed);

}  // namespace penumbra::testing
