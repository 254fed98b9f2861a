// One shadow, waited for with its progress shown.
#pragma once

#include <memory>
#include <stop_token>
#include <string>

#include "absl/status/statusor.h"
#include "client/cli/console.h"
#include "render/engine/engine.h"

namespace penumbra {

// The final artifact of `spec`, called `label` on the progress line.
//
// Errors  those of ComputeOnce
absl::StatusOr<std::shared_ptr<const Artifact>> ComputeShadow(
    Engine& engine, const std::string& scene_id, const ArtifactSpec& spec, const std::string& label,
    ProgressLine& progress, std::stop_token stop);

// Says what the technique warns of, if it does.
void NoteWarning(const Artifact& artifact, const std::string& label, const Console& console);

}  // namespace penumbra
