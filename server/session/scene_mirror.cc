#include "server/session/scene_mirror.h"

#include <string>
#include <utility>
#include <vector>

#include "proto/convert/geometry_convert.h"
#include "proto/convert/scene_convert.h"
#include "render/scene/scene_difference.h"

namespace penumbra {
namespace {

// Revisions, hash and envelope of a SceneUpdate.
constexpr size_t kEnvelopeBytes = 128;

}  // namespace

void SceneMirror::Offer(std::shared_ptr<const Scene> scene) {
  if (!newest_ || newest_->revision() < scene->revision()) newest_ = std::move(scene);
}

bool SceneMirror::CanTellOwnCommit(const std::shared_ptr<const Scene>& scene) {
  if (in_update()) return false;
  if (told_ && told_->revision() >= scene->revision()) return true;
  if (told_ && told_->revision() + 1 == scene->revision()) {
    told_ = scene;
    return true;
  }
  CatchUp(scene);
  return false;
}

bool SceneMirror::HasUpdate() const {
  return in_update() || (newest_ && (!told_ || told_->revision() < newest_->revision()));
}

v1::SceneUpdate SceneMirror::NextUpdate() {
  if (!in_update()) CatchUp(newest_);
  v1::SceneUpdate update = std::move(pieces_.front());
  pieces_.pop_front();
  return update;
}

void SceneMirror::CatchUp(std::shared_ptr<const Scene> scene) {
  const auto from = told_ ? told_ : Scene::Empty(scene->id());
  for (auto& piece :
       ToProtoPieces(Difference(*from, *scene), max_message_bytes_ - kEnvelopeBytes)) {
    v1::SceneUpdate& update = pieces_.emplace_back();
    update.set_from_revision(from->revision());
    update.set_revision(scene->revision());
    update.set_content_hash(ToProto(scene->content_hash()));
    update.set_is_snapshot(!told_ && pieces_.size() == 1);
    *update.mutable_delta() = std::move(piece);
    update.set_is_continued(true);
  }
  pieces_.back().set_is_continued(false);
  told_ = std::move(scene);
}

}  // namespace penumbra
