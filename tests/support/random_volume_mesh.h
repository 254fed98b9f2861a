// Shadow volume meshes of no scene, for what only carries them.
#pragma once

#include <cstdint>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "render/artifact/shadow_volume_mesh.h"
#include "render/scene/content_hash.h"

namespace penumbra::testing {

// Depths of `width` × `height` samples, hills with holes where nothing is seen.
inline VolumeFace RandomVolumeFace(std::mt19937& random, uint32_t width, uint32_t height) {
  VolumeFace face{.border = VolumeBorder::kOthers};
  face.map.view.window = {.min = DVec2(-1, -0.5), .max = DVec2(1, 0.5)};
  face.map.view.width = width;
  face.map.view.height = height;
  face.map.view.near = 0.5, face.map.view.far = 9;
  std::uniform_real_distribution<float> depth(1, 8);
  for (uint32_t i = 0; i < width * height; ++i) {
    face.map.depths.push_back(random() % 9 == 0 ? kNoDepth : depth(random));
  }
  return face;
}

// A strip of triangles from place to place; every fifth place is infinitely far.
inline ShadowVolume RandomVolume(uint32_t seed, uint32_t triangles, VolumeKind kind) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> place(-5, 5);
  ShadowVolume volume{.instance_id = kind == VolumeKind::kObject ? "thing" : "", .kind = kind};
  for (uint8_t& byte : volume.content.bytes) byte = static_cast<uint8_t>(random());
  if (kind != VolumeKind::kObject) {
    volume.faces = {RandomVolumeFace(random, 150, 70), RandomVolumeFace(random, 64, 64)};
  }
  for (uint32_t i = 0; i < triangles + 2; ++i) {
    volume.vertices.emplace_back(place(random), place(random), place(random),
                                 i % 5 == 4 ? 0.0f : 1.0f);
  }
  for (uint32_t i = 0; i < triangles; ++i) {
    volume.indices.insert(volume.indices.end(), {i, i + 1, i + 2});
    if (kind != VolumeKind::kObject) continue;
    volume.weights.push_back(static_cast<int8_t>(i % 4 == 0 ? -2 : 1));
    // Every fifth, from the fourth on, is infinitely far.
    volume.caster_indices.insert(volume.caster_indices.end(), {i / 5 * 5, i / 10 * 5 + 1, 2});
  }
  return volume;
}

}  // namespace penumbra::testing
