// One artifact, waited for.
//
//   auto artifact = ComputeOnce(engine, "studio", spec);
//   if (!artifact.ok()) return artifact.status();
#pragma once

#include <functional>
#include <memory>
#include <stop_token>
#include <string>

#include "absl/status/statusor.h"
#include "render/engine/engine.h"

namespace penumbra {

struct ComputeOnceOptions {
  std::function<void(const Artifact&)> progress = nullptr;  // takes coarse artifacts; may be null
  std::stop_token stop{};
};

// Subscribes and blocks until the final artifact of `spec` comes, of the scene as it is at the call
// or newer. Works with any engine. Not from inside a callback.
//
// Errors  those of Subscribe and of the technique; kCancelled: stop requested
absl::StatusOr<std::shared_ptr<const Artifact>> ComputeOnce(Engine& engine,
                                                            const std::string& scene_id,
                                                            const ArtifactSpec& spec,
                                                            ComputeOnceOptions options = {});

}  // namespace penumbra
