// A change too large for one commit.
//
//   auto revision = CommitInParts(engine, "studio", delta);
//   if (!revision.ok()) return revision.status();   // a part of it may be in
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "render/engine/engine.h"

namespace penumbra {

// Commits `delta` whole where it fits into a commit. Where it does not, and this is not what
// Engine::Commit promises, in as many commits as it takes: others see what lies between, and when a
// part is refused those before it stay. Receivers on instances that the delta changes are taken
// away first and come back last. A base revision is asked of the first part alone.
//
// Returns the revision after the last part. Errors  those of Engine::Commit, a field path's index
// counted within the part
absl::StatusOr<Revision> CommitInParts(Engine& engine, const std::string& scene_id,
                                       const SceneDelta& delta);

}  // namespace penumbra
