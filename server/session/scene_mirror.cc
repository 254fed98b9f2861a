#include "server/session/scene_mirror.h"

#include <utility>

namespace penumbra {

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

grpc::ByteBuffer SceneMirror::NextUpdate() {
  if (!in_update()) CatchUp(newest_);
  grpc::ByteBuffer message = (*pieces_)[next_piece_++];
  if (next_piece_ == pieces_->size()) pieces_ = nullptr;
  return message;
}

void SceneMirror::CatchUp(std::shared_ptr<const Scene> scene) {
  pieces_ = updates_.Between(told_, scene);
  next_piece_ = 0;
  told_ = std::move(scene);
}

}  // namespace penumbra
