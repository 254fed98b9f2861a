#include "client/session/mirrored_scene.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "proto/convert/geometry_convert.h"
#include "proto/convert/scene_convert.h"

namespace penumbra {
namespace {

absl::Status OutOfStep(const std::string& text) {
  return absl::DataLossError(absl::StrCat("the mirror of the scene is out of step: ", text));
}

// No change of a scene that keeps to the limits is as long; one whose end never comes is.
bool IsTooLong(const v1::SceneDelta& delta, const SceneLimits& limits) {
  const auto items = static_cast<uint64_t>(delta.upsert_instances_size()) +
                     static_cast<uint64_t>(delta.remove_instances_size()) +
                     static_cast<uint64_t>(delta.upsert_lights_size()) +
                     static_cast<uint64_t>(delta.remove_lights_size()) +
                     static_cast<uint64_t>(delta.upsert_receivers_size()) +
                     static_cast<uint64_t>(delta.remove_receivers_size());
  return items > 2 * (limits.max_instances + limits.max_lights + limits.max_receivers);
}

// Twice what a full scene takes.
uint64_t MostBytes(const SceneLimits& limits) {
  // Of an instance, a light or a receiver besides its two ids and its polygon: 150 at most, and 60
  // of a piece of its own.
  constexpr uint64_t kObjectBytes = 512;
  constexpr uint64_t kVertexBytes = 12;
  // Whatever limits a server tells of; with the usual ones it is 200 MiB.
  constexpr uint64_t kMostBytes = uint64_t{1} << 30;
  const uint64_t objects = limits.max_instances + limits.max_lights + limits.max_receivers;
  const uint64_t vertices = limits.max_receivers * limits.max_polygon_vertices;
  const uint64_t bytes = objects * (kObjectBytes + 2 * limits.max_id_bytes);
  return std::min(2 * (bytes + vertices * kVertexBytes), kMostBytes);
}

}  // namespace

MirroredScene::MirroredScene(const std::string& scene_id, BlobTransfer& blobs)
    : blobs_(blobs), scene_(Scene::Empty(scene_id)) {}

bool MirroredScene::Push(v1::SceneUpdate update) {
  update.DiscardUnknownFields();
  const bool is_continued = update.is_continued();
  const uint64_t bytes = update.ByteSizeLong();
  std::lock_guard lock(mutex_);
  if (pieces_) {
    pieces_->mutable_delta()->MergeFrom(update.delta());
    pieces_->set_is_continued(is_continued);
    pieces_bytes_ += bytes;
  } else {
    pieces_ = std::move(update);
    pieces_bytes_ = bytes;
  }
  // What is too long is not waited for: to apply it fails.
  const SceneLimits& limits = blobs_.scene_limits();
  if (is_continued && !IsTooLong(pieces_->delta(), limits) && pieces_bytes_ <= MostBytes(limits)) {
    return false;
  }
  pushed_revision_ = pieces_->revision();
  pushed_hash_ = pieces_->content_hash();
  has_content_ = true;
  events_.emplace_back(*std::exchange(pieces_, std::nullopt));
  return !std::exchange(is_catching_up_, true);
}

void MirroredScene::PushOwn(SceneDelta delta, Revision revision, std::string content_hash) {
  std::lock_guard lock(mutex_);
  // A SceneUpdate has covered it already where others have committed as well.
  if (revision <= pushed_revision_) return;
  pushed_revision_ = revision;
  pushed_hash_ = content_hash;
  events_.emplace_back(OwnCommit{std::move(delta), revision, std::move(content_hash)});
}

void MirroredScene::DropPieces() {
  std::lock_guard lock(mutex_);
  pieces_.reset();
}

std::optional<MirroredScene::Point> MirroredScene::pushed_point() const {
  std::lock_guard lock(mutex_);
  if (!has_content_) return std::nullopt;
  return Point{pushed_revision_, pushed_hash_};
}

bool MirroredScene::ApplyNext(bool own_only) {
  Event event;
  {
    std::lock_guard lock(mutex_);
    if (!status_.ok()) events_.clear();
    if (events_.empty()) return false;
    if (own_only && !std::holds_alternative<OwnCommit>(events_.front())) return false;
    event = std::move(events_.front());
    events_.pop_front();
  }
  last_try_ = std::visit([this](const auto& e) { return Apply(e); }, event);
  if (absl::IsUnavailable(last_try_) && !stop_.stop_requested()) {
    // Meshes are fetched from a server that is away.
    std::lock_guard lock(mutex_);
    events_.push_front(std::move(event));
    return false;
  }
  status_ = last_try_;
  return true;
}

void MirroredScene::CatchUp() {
  for (;;) {
    const bool is_stuck = absl::IsUnavailable(Newest().status());
    std::lock_guard lock(mutex_);
    if (!events_.empty() && !is_stuck) continue;
    is_catching_up_ = false;
    return;
  }
}

void MirroredScene::CatchUpOwn() {
  std::unique_lock applying(applying_, std::try_to_lock);
  while (applying && ApplyNext(/*own_only=*/true)) {
  }
}

absl::StatusOr<std::shared_ptr<const Scene>> MirroredScene::Newest() {
  std::lock_guard applying(applying_);
  while (ApplyNext(/*own_only=*/false)) {
  }
  if (!status_.ok()) return status_;
  if (absl::IsUnavailable(last_try_)) return last_try_;
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
  auto before = Applied();
  if (update.is_snapshot()) {
    before = Scene::Empty(before->id());
  } else if (update.from_revision() != before->revision()) {
    return OutOfStep(absl::StrCat("found a change from revision ", update.from_revision(),
                                  ", need one from ", before->revision()));
  }
  if (update.is_continued() || IsTooLong(update.delta(), blobs_.scene_limits())) {
    return OutOfStep("found a change of more than a scene may hold");
  }
  const auto fetched = blobs_.Fetch(update.delta(), stop_.get_token());
  if (!fetched.ok()) return fetched.status();
  const auto delta = FromProto(update.delta(), **fetched);
  if (!delta.ok()) return delta.status();
  const auto scene = before->Apply(*delta, blobs_.scene_limits());
  if (!scene.ok()) return OutOfStep(std::string(scene.status().message()));
  return Publish((*scene)->WithRevision(update.revision()), update.content_hash());
}

absl::Status MirroredScene::Apply(const OwnCommit& commit) {
  const auto before = Applied();
  if (commit.revision != before->revision() + 1) {
    return OutOfStep(
        absl::StrCat("found revision ", commit.revision, ", need ", before->revision() + 1));
  }
  SceneDelta delta = commit.delta;
  delta.base_revision.reset();
  auto scene = before->Apply(delta, blobs_.scene_limits());
  if (!scene.ok()) return OutOfStep(std::string(scene.status().message()));
  return Publish(*std::move(scene), commit.content_hash);
}

absl::Status MirroredScene::Publish(std::shared_ptr<const Scene> scene,
                                    const std::string& content_hash) {
  if (ToProto(scene->content_hash()) != content_hash) {
    return OutOfStep(absl::StrCat("found another content hash than the server's at revision ",
                                  scene->revision()));
  }
  std::lock_guard lock(mutex_);
  scene_ = std::move(scene);
  return absl::OkStatus();
}

}  // namespace penumbra
