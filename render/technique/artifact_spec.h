// What a client asks for.
#pragma once

#include <string>

#include "render/technique/technique_params.h"

namespace penumbra {

struct ArtifactSpec {
  TechniqueParams params;
  std::string light_id;
  std::string receiver_id;

  friend bool operator==(const ArtifactSpec&, const ArtifactSpec&) = default;
};

// Text that is equal for equal specs; jobs are keyed by it.
std::string SpecKey(const ArtifactSpec& spec);

}  // namespace penumbra
