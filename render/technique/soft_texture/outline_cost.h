// When an occluder's outline is drawn sooner than its faces: the cost model of `auto`.
//
//   saving = OutlineSavingNs({.faces = …, .faces_in_region = …, .border_edges = …});
//   if (saving > FillNs(texels)) …
//
// The constants are of one thread of a processor with AVX2, from `penumbra_bench --suite methods`;
// docs/performance.md has the experiment. They matter as ratios: a machine twice as fast chooses
// the same.
#pragma once

#include <cstddef>

#include "render/technique/soft_texture/outlined_occluder.h"
#include "render/technique/soft_texture/receiver_transform.h"

namespace penumbra {

// A texture seen from a light sample.
struct TextureView {
  const ReceiverTransform& map;
  uint32_t width, height;
};

struct OutlineWork {
  size_t faces = 0;            // of the mesh
  size_t faces_in_region = 0;  // those that would be drawn without an outline
  size_t border_edges = 0;     // edges of one face, which are on the outline from everywhere
};

// For each sample: setting up a face and filling the one or two rows of texels that it covers.
inline constexpr double kFaceNs = 9.5;
// For each sample and face of the mesh: the share of finding the outline and of flagging it.
inline constexpr double kOutlineFaceNs = 1.5;
inline constexpr double kBorderEdgeNs = 4;
// For each sample and mesh, however small.
inline constexpr double kOutlineMeshNs = 250;
// For each sample and texel of the rectangle around all outlines: what adding up flags takes more
// than filling faces.
inline constexpr double kFillTexelNs = 0.11;

// What one sample's shadow costs less by the outline, but for adding up the flags. May be negative.
constexpr double OutlineSavingNs(const OutlineWork& work) {
  return kFaceNs * static_cast<double>(work.faces_in_region) -
         kOutlineFaceNs * static_cast<double>(work.faces) -
         kBorderEdgeNs * static_cast<double>(work.border_edges) - kOutlineMeshNs;
}

OutlineWork WorkOf(const OutlinedOccluder& occluder);

// The rectangle around the shadows of boxes; the whole texture where one reaches as high as the
// light.
class ShadowRectangle {
 public:
  explicit ShadowRectangle(const TextureView& texture) : texture_(texture) {}

  void Add(const Aabb& box);
  double Texels() const;

 private:
  const TextureView& texture_;
  DVec2 low_{1.0}, high_{0.0};  // u and v
};

// What adding up the flags of `texels` costs, once for all outlines.
constexpr double FillNs(double texels) { return kFillTexelNs * texels; }

}  // namespace penumbra
