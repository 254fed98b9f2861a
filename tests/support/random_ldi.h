// Layered attenuation maps of nothing in particular.
#pragma once

#include <cstdint>
#include <random>

#include "render/artifact/attenuation_ldi.h"

namespace penumbra {

// W×H pixels with up to four layers each, between 0.5 and 4.5 m away or, from infinitely far,
// between −3 and 1 m.
inline LdiFace RandomLdiFace(uint32_t width, uint32_t height, bool from_infinity, uint32_t samples,
                             std::mt19937& random) {
  LdiFace face;
  face.view = {.frame = {.origin = {1, 2, 3}},
               .from_infinity = from_infinity,
               .window = {.min = {-1, -2}, .max = {2, 1}},
               .width = width,
               .height = height,
               .near = from_infinity ? -3.0 : 0.5,
               .far = from_infinity ? 1.0 : 4.5};
  face.offsets = {0};
  for (uint32_t p = 0; p < width * height; ++p) {
    float depth = from_infinity ? -3.0f : 0.5f;
    for (uint32_t layers = random() % 5; layers > 0; --layers) {
      depth += 1e-3f * static_cast<float>(1 + random() % 1000);
      face.depths.push_back(depth);
      face.counts.push_back(static_cast<uint16_t>(random() % (samples + 1)));
    }
    face.offsets.push_back(static_cast<uint32_t>(face.depths.size()));
  }
  return face;
}

// Two faces, of which one sees in parallel, whose images do not end where tiles do.
inline AttenuationLdi RandomLdi(uint32_t samples) {
  std::mt19937 random(samples);
  AttenuationLdi ldi{.light = {.id = "lamp", .shape = DiskLight{.radius = 0.5f}},
                     .faces = {},
                     .sample_count = samples,
                     .tolerance = 1.25f};
  ldi.faces.push_back(RandomLdiFace(70, 33, false, samples, random));
  ldi.faces.push_back(RandomLdiFace(5, 3, true, samples, random));
  return ldi;
}

}  // namespace penumbra
