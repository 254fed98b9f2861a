// Layered attenuation maps as deep OpenEXR files, for other programs and back.
//
//   absl::Status status = WriteDeepExr("lamp.exr", ldi);
//   absl::StatusOr<AttenuationLdi> same = ReadDeepExr("lamp.exr");
//
// One part a face. Each pixel has its layers as samples, nearest first:
//
//   Z            float, the depth in metres along the way that the face looks
//   attenuation  float, the fraction of the light that sees the layer, in [0, 1]
//
// The part's attributes have the view twice: as worldToCamera and worldToNDC, which other programs
// know, and to the last bit in penumbra:view; and, in the first part, the light, the number of its
// samples and the tolerance.
#pragma once

#include <filesystem>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "render/artifact/attenuation_ldi.h"

namespace penumbra {

// All of the file or none: it is written beside its place and then put there.
//
// Errors  kInvalidArgument: a map without faces; kUnavailable: cannot be written
absl::Status WriteDeepExr(const std::filesystem::path& path, const AttenuationLdi& ldi);

// What WriteDeepExr wrote. Errors  kNotFound; kInvalidArgument: not such a file
absl::StatusOr<AttenuationLdi> ReadDeepExr(const std::filesystem::path& path);

}  // namespace penumbra
