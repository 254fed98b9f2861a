#include "client/session/mirrored_scene.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "proto/convert/geometry_convert.h"
#include "proto/convert/scene_convert.h"

namespace penumbra {
namespace {

absl::Status OutOfStep(const std::string& text) {
  return absl::DataLossError(absl::StrCat("the mirror of the scene is out of step: ", text));
}

}  // namespace

MirroredScene::MirroredScene(const std::string& scene_id, BlobTransfer& blobs)
    : blobs_(blobs), next_(Scene::Empty(scene_id)), scene_(next_) {}

void MirroredScene::Push(v1::SceneUpdate update) {
  std::lock_guard lock(mutex_);
  if (!update.is_continued()) {
    pushed_revision_ = update.revision();
    has_content_ = true;
  }
  events_.emplace_back(std::move(update));
}

void MirroredScene::PushOwn(SceneDelta delta, Revision revision, std::string content_hash) {
  std::lock_guard lock(mutex_);
  // A SceneUpdate has covered it already where others have committed as well.
  if (revision <= pushed_revision_) return;
  pushed_revision_ = revision;
  events_.emplace_back(OwnCommit{std::move(delta), revision, std::move(content_hash)});
}

absl::StatusOr<std::shared_ptr<const Scene>> MirroredScene::Newest() {
  std::lock_guard applying(applying_);
  for (;;) {
    Event event;
    {
      std::lock_guard lock(mutex_);
      if (!status_.ok()) events_.clear();
      if (events_.empty()) break;
      event = std::move(events_.front());
      events_.pop_front();
    }
    status_ = std::visit([this](const auto& e) { return Apply(e); }, event);
  }
  if (!status_.ok()) return status_;
  return Applied();
}

std::shared_ptr<const Scene> MirroredScene::Applied() const {
  std::lock_guard lock(mutex_);
  return scene_;
}

bool MirroredScene::has_content() const {
  std::lock_guard lock(mutex_);
  return has_content_;
}

Revision MirroredScene::pushed_revision() const {
  std::lock_guard lock(mutex_);
  return pushed_revision_;
}

absl::Status MirroredScene::Apply(const v1::SceneUpdate& update) {
  if (!is_continued_) {
    if (update.is_snapshot()) {
      next_ = Scene::Empty(next_->id());
    } else if (update.from_revision() != next_->revision()) {
      return OutOfStep(absl::StrCat("found a change from revision ", update.from_revision(),
                                    ", need one from ", next_->revision()));
    }
  }
  is_continued_ = update.is_continued();

  const auto fetched = blobs_.Fetch(update.delta());
  if (!fetched.ok()) return fetched.status();
  const auto delta = FromProto(update.delta(), **fetched);
  if (!delta.ok()) return delta.status();
  auto scene = next_->Apply(*delta, blobs_.scene_limits());
  if (!scene.ok()) return OutOfStep(std::string(scene.status().message()));
  next_ = *std::move(scene);
  if (is_continued_) return absl::OkStatus();

  next_ = next_->WithRevision(update.revision());
  if (absl::Status status = Check(*next_, update.content_hash()); !status.ok()) return status;
  Publish(next_);
  return absl::OkStatus();
}

absl::Status MirroredScene::Apply(const OwnCommit& commit) {
  if (commit.revision != next_->revision() + 1) {
    return OutOfStep(
        absl::StrCat("found revision ", commit.revision, ", need ", next_->revision() + 1));
  }
  SceneDelta delta = commit.delta;
  delta.base_revision.reset();
  auto scene = next_->Apply(delta, blobs_.scene_limits());
  if (!scene.ok()) return OutOfStep(std::string(scene.status().message()));
  next_ = *std::move(scene);
  if (absl::Status status = Check(*next_, commit.content_hash); !status.ok()) return status;
  Publish(next_);
  return absl::OkStatus();
}

absl::Status MirroredScene::Check(const Scene& scene, const std::string& content_hash) const {
  if (ToProto(scene.content_hash()) == content_hash) return absl::OkStatus();
  return OutOfStep(
      absl::StrCat("found another content hash than the server's at revision ", scene.revision()));
}

void MirroredScene::Publish(std::shared_ptr<const Scene> scene) {
  std::lock_guard lock(mutex_);
  scene_ = std::move(scene);
}

}  // namespace penumbra
