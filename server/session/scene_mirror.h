// What a client has been told of its scene, and what it must be told to catch up.
//
// It holds the last scene told and the newest one, and finds the difference when there is room to
// send it: commits that come faster than the client reads melt into one.
#pragma once

#include <cstddef>
#include <memory>
#include <utility>

#include "grpcpp/support/byte_buffer.h"
#include "render/scene/scene.h"
#include "server/session/scene_updates.h"

namespace penumbra {

class SceneMirror {
 public:
  // `updates` outlives it.
  explicit SceneMirror(SceneUpdates& updates) : updates_(updates) {}

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
  // The next message of an update. Only where HasUpdate().
  grpc::ByteBuffer NextUpdate();
  // Whether the pieces of an update are on their way.
  bool in_update() const { return pieces_ != nullptr; }

 private:
  void CatchUp(std::shared_ptr<const Scene> scene);

  SceneUpdates& updates_;
  std::shared_ptr<const Scene> told_;    // null: nothing yet
  std::shared_ptr<const Scene> newest_;  // null: not known
  // Of the update under way; null: none.
  std::shared_ptr<const SceneUpdates::Messages> pieces_;
  size_t next_piece_ = 0;
};

}  // namespace penumbra
