// What a request means for techniques that compute at points.
#pragma once

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/cli/commands.h"
#include "client/import/import_scene.h"
#include "render/scene/point_receiver.h"

namespace penumbra {

struct PlannedPoints {
  std::string name;  // of files
  PointReceiver receiver;
};

// The lightmaps and the points that the request names, and its picture, if there is anything about
// one or nothing else is named. Where no camera is given it is the file's first, or one that has
// all in sight.
//
// Errors  kNotFound, UNKNOWN_ID: no such instance; those of ReadPoints; kInvalidArgument: the
//         camera, or a part that is not in the picture
absl::StatusOr<std::vector<PlannedPoints>> PlanPoints(const ImportedScene& imported,
                                                      const ShadowRequest& request);

// Points with normals from a file of text: six numbers a line, x y z and the normal's; what follows
// a # is not looked at.
//
// Errors  kNotFound; kInvalidArgument NUMBER, NUMBER_COUNT, with the line; kResourceExhausted
//         QUOTA_POINTS
absl::StatusOr<GivenPoints> ReadPoints(const std::filesystem::path& path);

}  // namespace penumbra
