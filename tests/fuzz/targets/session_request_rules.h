// What holds of one request of a session, whoever sends it.
#pragma once

#include <string>

#include "penumbra/v1/session.pb.h"
#include "render/scene/scene.h"
#include "server/limits.h"

namespace penumbra::fuzzing {

// `request` is what ParseBounded has taken from `bytes`: few bytes have not become much memory, and
// what was taken is taken again and says the same.
void RequireBounded(const std::string& bytes, const ServerLimits& limits,
                    const v1::SessionRequest& request);

// Specs, views and hashes in it that are understood mean the same when they are said again.
void RequireMeaning(const v1::SessionRequest& request, const Scene& scene);

}  // namespace penumbra::fuzzing
