// The scenes of a load: "load0", "load1", …, in each of which every client moves a box of its own.
//
//   auto before = MakeScenes(server, 50);
#pragma once

#include <map>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "render/scene/scene.h"

namespace penumbra::load {

// By id.
using ScenesBefore = std::map<std::string, std::shared_ptr<const Scene>>;

std::string SceneId(int number);

Instance BoxOf(int client);

// Makes them anew, with one box that nobody moves, on a connection that has ended when it returns:
// an engine mirrors all the scenes that it has used, which is a load too.
//
// Errors  those of RemoteEngine
absl::StatusOr<ScenesBefore> MakeScenes(const std::string& server, int count);

}  // namespace penumbra::load
