// Whether shadow widths fit into what a device draws from, told before they are computed.
//
//   const auto compute = [&](const PlannedShadow& s) { return ComputeShadow(…, s.spec, …); };
//   absl::Status status = CheckWidthsFit(wanted, {.bytes = 1 << 27, .device = "…"}, compute);
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/cli/shadow_plan.h"
#include "render/artifact/artifact.h"

namespace penumbra {

struct DrawRoom {
  uint64_t bytes = 0;  // for all maps and traced pixels of a picture
  std::string device;
};

// Computes a shadow as it is planned.
using ComputePlanned =
    std::function<absl::StatusOr<std::shared_ptr<const Artifact>>(const PlannedShadow& shadow)>;

// Where there might be too many, maps of an eighth of the sides are computed, and tell how large
// the planned ones become, to 2 %. Other techniques are not looked at.
//
// Errors  kResourceExhausted QUOTA_DRAW_BYTES, "--set resolution": more than `room`, with the
//         resolution that fits; those of `compute`
// Cost    a sixty-fourth of the maps; nothing where six faces a light would fit
absl::Status CheckWidthsFit(const std::vector<PlannedShadow>& wanted, const DrawRoom& room,
                            const ComputePlanned& compute);

}  // namespace penumbra
