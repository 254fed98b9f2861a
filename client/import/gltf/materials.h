// What shadows need to know of a material.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "client/import/gltf/document.h"
#include "client/import/image.h"
#include "client/import/warnings.h"
#include "render/math/vec.h"
#include "render/scene/alpha_mask.h"

namespace penumbra::gltf {

// Where a texture is looked up: a set of uvs, put through KHR_texture_transform.
struct TextureCoordinates {
  int set = 0;  // TEXCOORD_<set>
  Vec2 offset{0.0f};
  float rotation = 0.0f;  // radians, counter-clockwise in an image whose v runs down
  Vec2 scale{1.0f};

  Vec2 Apply(Vec2 uv) const;
};

struct Material {
  Vec3 color{0.8f};  // linear RGB in [0, 1]; the mean over the base colour texture
  std::shared_ptr<const AlphaMask> mask;
  float cutoff = 0.5f;
  std::optional<TextureCoordinates> mask_uv;  // set with `mask`
  bool absent = false;                        // cut away everywhere: the surface is not there
  bool casts = true;                          // see-through surfaces do not
  Vec3 emission{0.0f};                        // W·m⁻²·sr⁻¹
  bool two_sided = false;
};

class Materials {
 public:
  Materials(Document& document, Warnings& warnings) : document_(document), warnings_(warnings) {}

  // Material `index`, or the default one for −1. Textures that cannot be read count as white and
  // opaque, with a warning.
  const Material& Get(int index);

 private:
  Material Read(int index);
  void ReadAlpha(int index, float factor, Material& material);
  Vec3 BaseColor(int index, float& alpha_factor);
  Vec3 Emission(int index);
  // Null when there is none or it cannot be read.
  const Image* TextureImage(int texture);
  Vec3 MeanColor(int texture);

  Document& document_;
  Warnings& warnings_;
  std::map<int, Material> known_;
  std::map<int, std::optional<Image>> images_;
};

}  // namespace penumbra::gltf
