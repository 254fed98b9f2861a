// A commit on its way into a scene's store, and what becomes of it.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "render/scene/scene.h"

namespace penumbra {

// A commit as a client asks for it.
struct CommitRequest {
  SceneDelta delta;
  std::string idempotency_key;  // empty: none
  ContentHash fingerprint;      // of the delta, where there is a key
  std::string author_name;      // for the scene's history
  std::string principal;        // for whose it counts while it waits for the disk
  uint64_t bytes = 0;           // of the message that it came in
};

struct CommitOutcome {
  Revision revision = 0;
  ContentHash content_hash;
  std::shared_ptr<const Scene> scene;  // null where an earlier answer was repeated
};

using CommitCallback = std::function<void(const absl::StatusOr<CommitOutcome>&)>;

}  // namespace penumbra
