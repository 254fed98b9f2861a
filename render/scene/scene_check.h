// What a commit checks of each object that it brings.
#pragma once

#include <string_view>

#include "absl/status/status.h"
#include "render/scene/area_light.h"
#include "render/scene/instance.h"
#include "render/scene/receiver.h"
#include "render/scene/scene_limits.h"

namespace penumbra {

// The first thing wrong with the object, its field path beginning with `path`
// ("upsert_lights[2]" → "upsert_lights[2].edge_v: …"). Errors as listed at Scene::Apply.
absl::Status CheckInstance(const Instance& instance, std::string_view path,
                           const SceneLimits& limits);
absl::Status CheckLight(const AreaLight& light, std::string_view path, const SceneLimits& limits);
absl::Status CheckReceiver(const Receiver& receiver, std::string_view path,
                           const SceneLimits& limits);
// As of a receiver's, but wherever it is: of one that is placed already. Errors: kInvalidArgument
// NON_FINITE, ZERO_AREA.
absl::Status CheckPatch(const Parallelogram& patch, std::string_view path);

}  // namespace penumbra
