// What a client has been told of its scene, and what it must be told to catch up.
//
// It holds the last scene told and the newest one, and finds the difference when there is room to
// send it: commits that come faster than the client reads melt into one.
#pragma once

#include <deque>
#include <memory>
#include <utility>

#include "penumbra/v1/session.pb.h"
#include "render/scene/scene.h"

namespace penumbra {

class SceneMirror {
 public:
  explicit SceneMirror(size_t max_message_bytes) : max_message_bytes_(max_message_bytes) {}

  // The client has `scene` already. Before anything else.
  void StartFrom(std::shared_ptr<const Scene> scene) { told_ = std::move(scene); }

  // There is a newer scene.
  void Offer(std::shared_ptr<const Scene> scene);

  // The client is about to hear that its own commit made `scene`. True if it can; false if updates
  // have to go first.
  bool CanTellOwnCommit(const std::shared_ptr<const Scene>& scene);

  // Of what the client has been told, or is being told.
  Revision told_revision() const { return told_ ? told_->revision() : 0; }

  bool HasUpdate() const;
  // Only where HasUpdate().
  v1::SceneUpdate NextUpdate();
  // Whether the pieces of an update are on their way.
  bool in_update() const { return !pieces_.empty(); }

 private:
  void CatchUp(std::shared_ptr<const Scene> scene);

  const size_t max_message_bytes_;
  std::shared_ptr<const Scene> told_;    // null: nothing yet
  std::shared_ptr<const Scene> newest_;  // null: not known
  std::deque<v1::SceneUpdate> pieces_;
};

}  // namespace penumbra
