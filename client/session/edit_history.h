// Undo and redo of one's own edits. Both are ordinary commits: others see them as such, and what
// others have edited since is not undone with it.
//
//   EditHistory history(engine, "studio");
//   history.Commit(delta);
//   history.Undo();      // what `delta` touched is as it was before
#pragma once

#include <cstddef>
#include <deque>
#include <memory>
#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "client/session/remote_engine_options.h"
#include "render/engine/engine.h"

namespace penumbra {

// One thread at a time.
class EditHistory {
 public:
  // Remembers at most `max_edits`; the engine must outlive it. Where others commit first it tries
  // again for `patience_s`, by default as long as any other call may take.
  EditHistory(Engine& engine, std::string scene_id, size_t max_edits = 100,
              double patience_s = RemoteEngineOptions().call_timeout_s)
      : engine_(engine),
        scene_id_(std::move(scene_id)),
        max_edits_(max_edits),
        patience_s_(patience_s) {}

  // Commits and remembers. There is nothing to redo any more then.
  // Errors  kAborted STALE_BASE: others commit too fast; those of Engine::Commit
  absl::StatusOr<Revision> Commit(const SceneDelta& delta);

  // Commits the opposite of the newest edit that is not undone; and of the newest undo.
  //
  // Errors  kFailedPrecondition NOTHING_TO_UNDO, NOTHING_TO_REDO; EDITED_SINCE: an object that the
  //         edit touched is not as the edit left it: its field path names it, nothing has changed,
  //         and the edit is forgotten; those of Engine::Commit
  absl::StatusOr<Revision> Undo();
  absl::StatusOr<Revision> Redo();

  bool can_undo() const { return !done_.empty(); }
  bool can_redo() const { return !undone_.empty(); }

 private:
  // The scene before and after a commit.
  struct Edit {
    std::shared_ptr<const Scene> before;
    std::shared_ptr<const Scene> after;
  };

  absl::StatusOr<Edit> CommitOnNewest(const SceneDelta& delta);
  absl::StatusOr<Revision> Turn(std::deque<Edit>& from, std::deque<Edit>& to, const char* nothing);

  Engine& engine_;
  const std::string scene_id_;
  const size_t max_edits_;
  const double patience_s_;
  std::deque<Edit> done_;    // oldest first
  std::deque<Edit> undone_;  // the next to redo last
};

}  // namespace penumbra
