// Artifacts as one message, and what is held against what.
#pragma once

#include <memory>

#include "penumbra/v1/artifact.pb.h"
#include "render/artifact/artifact.h"

namespace penumbra::fuzzing {

// All of it: header, light samples, tiles, parts.
v1::ArtifactUpdate WholeUpdate(const Artifact& artifact, uint64_t sequence);

// The same with its planes as they are instead of packed, so that a changed byte is a changed
// number.
v1::ArtifactUpdate WithRawPlanes(v1::ArtifactUpdate update);

// Ends the process where the artifact is not what render/artifact says it is, where it cannot be
// looked up in, or where it is another one after a way over the wire.
void RequireSound(const std::shared_ptr<const Artifact>& artifact, const SceneLimits& limits);

}  // namespace penumbra::fuzzing
