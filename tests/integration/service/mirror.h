// What a client that mirrors a scene holds, kept as the protocol says and checked at each step.
#pragma once

#include <map>
#include <memory>
#include <string>

#include "gtest/gtest.h"
#include "proto/convert/geometry_convert.h"
#include "proto/convert/scene_convert.h"
#include "tests/integration/service/studio.h"

namespace penumbra::testing {

class Mirror : public BlobSource {
 public:
  // A mesh that the scene may come to hold, besides the box.
  void Know(const std::shared_ptr<const Mesh>& mesh) { meshes_[ToProto(mesh->id())] = mesh; }

  std::shared_ptr<const Mesh> FindMesh(const ContentHash& hash) const override {
    const auto found = meshes_.find(ToProto(hash));
    return found == meshes_.end() ? BoxMesh() : found->second;
  }
  std::shared_ptr<const AlphaMask> FindMask(const ContentHash&) const override { return nullptr; }

  void Apply(const v1::SceneUpdate& update) {
    if (update.is_snapshot()) scene = Scene::Empty("studio");
    EXPECT_EQ(update.from_revision(), update.is_snapshot() ? 0 : revision);
    pieces_.MergeFrom(update.delta());
    if (update.is_continued()) return;
    scene = scene->Apply(FromProto(pieces_, *this).value()).value();
    pieces_.Clear();
    revision = update.revision();
    EXPECT_EQ(ToProto(scene->content_hash()), update.content_hash());
  }

  std::shared_ptr<const Scene> scene = Scene::Empty("studio");
  uint64_t revision = 0;

 private:
  std::map<std::string, std::shared_ptr<const Mesh>> meshes_;
  v1::SceneDelta pieces_;  // of a change that goes on
};

}  // namespace penumbra::testing
