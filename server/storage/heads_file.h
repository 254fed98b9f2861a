// How far each scene had come at some time, apart from the scenes' own files.
//
// A file of which the end has been cut off, or that has gone altogether, may look sound. This one
// tells: no scene may have less than what stands here. It is written a while after commits and
// before a scene's creation or removal is acknowledged, so what it says is never too much.
#pragma once

#include <map>
#include <string>

#include "absl/status/statusor.h"
#include "server/storage/scene_record.h"

namespace penumbra {

struct KnownHead {
  std::string incarnation;  // of the scene, 16 bytes
  Revision revision = 0;

  bool operator==(const KnownHead&) const = default;
};

using KnownHeads = std::map<std::string, KnownHead>;  // by scene id

// Errors  kResourceExhausted, kUnavailable: as WriteDurably
absl::Status WriteHeads(const std::string& path, const KnownHeads& heads);

// None where there is no file. Errors  kDataLoss DAMAGED: it is not as it was written
absl::StatusOr<KnownHeads> ReadHeads(const std::string& path);

}  // namespace penumbra
