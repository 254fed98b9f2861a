// Meshes and masks that scripts can name, and more that they bring.
#pragma once

#include <map>
#include <memory>
#include <variant>

#include "proto/convert/scene_convert.h"
#include "render/scene/blob.h"
#include "render/scene/content_hash.h"

namespace penumbra::fuzzing {

class KnownBlobs final : public BlobSource {
 public:
  void Add(const BlobContent& content) {
    if (const auto* mesh = std::get_if<std::shared_ptr<const Mesh>>(&content)) {
      meshes_[(*mesh)->id()] = *mesh;
    } else {
      const auto& mask = std::get<std::shared_ptr<const AlphaMask>>(content);
      masks_[mask->id()] = mask;
    }
  }

  std::shared_ptr<const Mesh> FindMesh(const ContentHash& hash) const override {
    const auto found = meshes_.find(hash);
    return found == meshes_.end() ? nullptr : found->second;
  }
  std::shared_ptr<const AlphaMask> FindMask(const ContentHash& hash) const override {
    const auto found = masks_.find(hash);
    return found == masks_.end() ? nullptr : found->second;
  }

 private:
  std::map<ContentHash, std::shared_ptr<const Mesh>> meshes_;
  std::map<ContentHash, std::shared_ptr<const AlphaMask>> masks_;
};

}  // namespace penumbra::fuzzing
