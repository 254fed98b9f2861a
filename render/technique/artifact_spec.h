// What a client asks for.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "render/scene/point_receiver.h"
#include "render/technique/technique_params.h"

namespace penumbra {

// As a light's id: all lights of the scene in one artifact. No light can be called so.
inline constexpr std::string_view kAllLights = "*";

struct ArtifactSpec {
  TechniqueParams params;
  std::string light_id;     // or kAllLights
  std::string receiver_id;  // of techniques for receivers; otherwise empty
  // How long after a commit the first artifact that shows it should be there, at the price of fewer
  // samples: > 0, in ms, and 0 for no such wish. Later passes refine it as ever.
  float time_budget_ms = 0;
  std::optional<PointReceiver> points = std::nullopt;  // of techniques for points, otherwise none

  friend bool operator==(const ArtifactSpec&, const ArtifactSpec&) = default;
};

// Errors  kInvalidArgument RANGE: a time budget that is negative or no number
absl::Status CheckTimeBudget(const ArtifactSpec& spec);

// Whether the spec says what its technique computes for, and nothing else.
//
// Errors  kInvalidArgument MISSING_FIELD, UNEXPECTED_FIELD at "receiver_id" or "points", BAD_ID;
//         those of Check(PointReceiver)
absl::Status CheckTarget(const ArtifactSpec& spec, const SceneLimits& limits = {});

// Text that is equal for equal specs; jobs are keyed by it.
std::string SpecKey(const ArtifactSpec& spec);

}  // namespace penumbra
