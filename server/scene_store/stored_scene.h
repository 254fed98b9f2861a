// Scenes and commits as they are kept on disk, both ways.
#pragma once

#include <memory>
#include <span>
#include <string>

#include "absl/status/statusor.h"
#include "proto/convert/scene_convert.h"
#include "render/scene/scene.h"
#include "server/storage/scene_file.h"

namespace penumbra {

// The whole scene.
SnapshotRecord SnapshotOf(const Scene& scene);

// The delta that led to `after` as bytes. Surfaces to receive on are written as the receivers that
// they became: how they are found may change.
std::string DeltaBytes(const Scene& before, const Scene& after, const SceneDelta& delta);

// The scene that `state` leads to.
//
// Errors, also of the next  kDataLoss DAMAGED: the bytes give no scene, or one of another content;
//                           those of `blobs`
absl::StatusOr<std::shared_ptr<const Scene>> SceneOf(const std::string& scene_id,
                                                     const SceneState& state,
                                                     const BlobSource& blobs,
                                                     const SceneLimits& limits);
// What the commits that follow make of `scene`.
absl::StatusOr<std::shared_ptr<const Scene>> SceneAfter(std::shared_ptr<const Scene> scene,
                                                        std::span<const CommitRecord> commits,
                                                        const BlobSource& blobs,
                                                        const SceneLimits& limits);

}  // namespace penumbra
