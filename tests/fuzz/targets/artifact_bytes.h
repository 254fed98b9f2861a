// Artifacts as bytes, to be compared.
#pragma once

#include <string>

#include "render/artifact/artifact.h"

namespace penumbra::fuzzing {

// Equal for artifacts that are equal to the last bit.
std::string BytesOfArtifact(const Artifact& artifact);

}  // namespace penumbra::fuzzing
