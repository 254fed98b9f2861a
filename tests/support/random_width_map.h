// Shadow-width maps of nothing in particular.
#pragma once

#include <cstdint>
#include <random>

#include "render/artifact/shadow_width_map.h"

namespace penumbra {

inline ShadowWidthLayer RandomWidthLayer(size_t texels, bool from_infinity, std::mt19937& random) {
  ShadowWidthLayer layer;
  for (size_t i = 0; i < texels; ++i) {
    const bool is_lit = random() % 4 == 0;
    const float part = 1e-3f * static_cast<float>(random() % 1000);
    const float depth = from_infinity ? -3 + 3 * part : 0.5f + 3 * part;
    layer.depths.push_back(is_lit ? kNoDepth : depth);
    const bool is_endless = random() % 32 == 0;  // as where no texel is lit
    layer.widths.push_back(is_lit ? 0.0f : is_endless ? kNoDepth : 0.01f + 0.2f * part);
  }
  return layer;
}

// Depths as RandomLdiFace has them.
inline ShadowWidthFace RandomWidthFace(uint32_t width, uint32_t height, bool from_infinity,
                                       bool has_far, std::mt19937& random) {
  ShadowWidthFace face;
  face.view = {.frame = {.origin = {1, 2, 3}},
               .from_infinity = from_infinity,
               .window = {.min = {-1, -2}, .max = {2, 1}},
               .width = width,
               .height = height,
               .near = from_infinity ? -3.0 : 0.5,
               .far = from_infinity ? 1.0 : 4.5};
  face.window = {.min = {-0.5, -1.5}, .max = {1.5, 0.75}};
  face.near = RandomWidthLayer(size_t{width} * height, from_infinity, random);
  if (has_far) face.far = RandomWidthLayer(size_t{width} * height, from_infinity, random);
  return face;
}

// Two faces, of which one sees in parallel, whose images do not end where tiles do.
inline ShadowWidthMap RandomWidthMap(uint32_t seed, bool has_far) {
  std::mt19937 random(seed);
  ShadowWidthMap map{.light = {.id = "lamp",
                               .shape = RectangleLight{.corner = {0.9f, 1.9f, 3},
                                                       .edge_u = {0.2f, 0, 0.05f},
                                                       .edge_v = {0, 0.3f, 0}}},
                     .faces = {}};
  map.faces.push_back(RandomWidthFace(70, 133, false, has_far, random));
  map.faces.push_back(RandomWidthFace(5, 3, true, has_far, random));
  return map;
}

}  // namespace penumbra
