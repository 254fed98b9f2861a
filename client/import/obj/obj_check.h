// Refuses an OBJ file that tinyobjloader would read as something else: what it cannot read becomes
// 0 there, or an index of nothing.
//
//   absl::Status status = CheckObj("v 0 nan 0\n", limits);
//   // INVALID_ARGUMENT: line 1: v: found "nan", need three finite numbers
#pragma once

#include <string_view>

#include "absl/status/status.h"
#include "render/scene/scene_limits.h"

namespace penumbra::obj {

// Vertices, texture coordinates, normals and faces; other statements pass. A face may name only
// what is defined above it.
//
// Errors  kInvalidArgument, reason MALFORMED: too few numbers or corners, or a word that is none;
//         NON_FINITE; OUT_OF_BOUNDS: beyond limits.max_coordinate; INDEX_RANGE
//         kResourceExhausted, reason TOO_LARGE: a face of thousands of corners
absl::Status CheckObj(std::string_view text, const SceneLimits& limits);

}  // namespace penumbra::obj
