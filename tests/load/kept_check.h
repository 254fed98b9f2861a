// Whether a server has kept all that it acknowledged of a load.
//
//   if (!HasKeptAll(before, engine, clients, deadline)) return EXIT_FAILURE;  // and says what not
#pragma once

#include <memory>
#include <vector>

#include "render/engine/engine.h"
#include "tests/load/load_client.h"
#include "tests/load/load_scenes.h"

namespace penumbra::load {

using LoadClients = std::vector<std::unique_ptr<LoadClient>>;

// Whether every scene of `before` is there and is what its commits make, and every client has been
// told so by `deadline`. Prints what was found.
bool HasKeptAll(const ScenesBefore& before, Engine& engine, const LoadClients& clients,
                Clock::time_point deadline);

}  // namespace penumbra::load
