// A picture of a server's scene, and of what becomes of it.
#pragma once

#include <stop_token>

#include "absl/status/status.h"
#include "client/cli/commands.h"
#include "client/cli/console.h"

namespace penumbra {

// From the camera given or followed, or one that has everything in sight. With `watch` a picture
// for each change of the camera and of the scene; those that come while one is drawn melt together.
// Where whoever is followed has left, their last camera stays, which is said.
//
// Errors  kDeadlineExceeded NOT_HERE, "--follow": there is no camera of theirs in time;
//         kFailedPrecondition AMBIGUOUS_NAME: several are called so, an id is needed; those of the
//         server and of drawing
absl::Status ViewServerScene(const ViewCommand& command, const Console& console,
                             const std::stop_token& stop);

}  // namespace penumbra
