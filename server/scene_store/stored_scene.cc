#include "server/scene_store/stored_scene.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "render/scene/scene_difference.h"
#include "server/storage/scene_rows.h"

namespace penumbra {
namespace {

absl::Status DamagedAt(Revision revision, absl::string_view found) {
  return Damaged(absl::StrCat("at revision ", revision, " ", found));
}

// `before` with what the bytes say applied.
absl::StatusOr<std::shared_ptr<const Scene>> Next(const Scene& before, const std::string& bytes,
                                                  Revision revision, const ContentHash& hash,
                                                  const BlobSource& blobs,
                                                  const SceneLimits& limits) {
  v1::SceneDelta message;
  if (!message.ParseFromString(bytes)) return DamagedAt(revision, "no delta");
  const auto delta = FromProto(message, blobs);
  if (!delta.ok()) return DamagedAt(revision, delta.status().message());
  const auto applied = before.Apply(*delta, limits);
  if (!applied.ok()) return DamagedAt(revision, applied.status().message());
  const auto scene = (*applied)->WithRevision(revision);
  if (scene->content_hash() != hash)
    return DamagedAt(revision, "another content than was committed");
  return scene;
}

}  // namespace

SnapshotRecord SnapshotOf(const Scene& scene) {
  const auto nothing = Scene::Empty(scene.id());
  return {.revision = scene.revision(),
          .content_hash = scene.content_hash(),
          .body = ToProto(Difference(*nothing, scene)).SerializeAsString()};
}

std::string DeltaBytes(const Scene& before, const Scene& after, const SceneDelta& delta) {
  v1::SceneDelta message =
      ToProto(delta.receive_on_planar_surfaces ? Difference(before, after) : delta);
  message.clear_base_revision();
  return message.SerializeAsString();
}

absl::StatusOr<std::shared_ptr<const Scene>> SceneOf(const std::string& scene_id,
                                                     const SceneState& state,
                                                     const BlobSource& blobs,
                                                     const SceneLimits& limits) {
  std::shared_ptr<const Scene> scene = Scene::Empty(scene_id);
  if (state.snapshot) {
    auto whole = Next(*scene, state.snapshot->body, state.snapshot->revision,
                      state.snapshot->content_hash, blobs, limits);
    if (!whole.ok()) return whole.status();
    scene = *std::move(whole);
  }
  return SceneAfter(std::move(scene), state.commits, blobs, limits);
}

absl::StatusOr<std::shared_ptr<const Scene>> SceneAfter(std::shared_ptr<const Scene> scene,
                                                        std::span<const CommitRecord> commits,
                                                        const BlobSource& blobs,
                                                        const SceneLimits& limits) {
  for (const CommitRecord& commit : commits) {
    auto next = Next(*scene, commit.delta, commit.revision, commit.content_hash, blobs, limits);
    if (!next.ok()) return next.status();
    scene = *std::move(next);
  }
  return scene;
}

}  // namespace penumbra
