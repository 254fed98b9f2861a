// A scene's history, read a piece at a time: commits to the scene go on between two pieces.
//
//   auto scene = PastScene(*log, revision, blobs, limits);
//   auto status = ForEachBody(*log, [&](std::string_view body) { … });
#pragma once

#include <functional>
#include <memory>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "proto/convert/scene_convert.h"
#include "render/scene/scene.h"
#include "server/scene_store/scene_log.h"

namespace penumbra {

// The scene as it was. What is forgotten while it is made may be what it is made of: then it is
// made of what is kept, or there is none.
//
// Errors  those of SceneLog::SnapshotFor; kDataLoss DAMAGED; those of `blobs`
absl::StatusOr<std::shared_ptr<const Scene>> PastScene(SceneLog& log, Revision revision,
                                                       const BlobSource& blobs,
                                                       const SceneLimits& limits);

// Every snapshot and delta that is kept, those that come meanwhile included; nothing is forgotten
// until then. A scene that has been removed has none.
//
// Errors  those of SceneLog and of `visit`; kAborted: the history was begun anew meanwhile, so that
//         some may have been missed
absl::Status ForEachBody(SceneLog& log, const std::function<absl::Status(std::string_view)>& visit);

}  // namespace penumbra
