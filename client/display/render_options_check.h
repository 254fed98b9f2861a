// What a picture may be asked to be.
#pragma once

#include "absl/status/status.h"
#include "client/display/thin_renderer.h"

namespace penumbra {

// Errors  kInvalidArgument: a number out of its range, or none; the field named
absl::Status CheckRenderOptions(const RenderOptions& options);

}  // namespace penumbra
