// Receivers that are points, both ways.
#pragma once

#include "absl/status/statusor.h"
#include "penumbra/v1/points.pb.h"
#include "render/scene/point_receiver.h"

namespace penumbra {

v1::PointReceiver ToProto(const PointReceiver& receiver);

// Numbers are taken as they are: Check(PointReceiver) looks at them.
//
// Errors  kInvalidArgument MISSING_FIELD: no kind that this program knows; LENGTH, fields named
//         "given.positions" and "given.normals"
absl::StatusOr<PointReceiver> FromProto(const v1::PointReceiver& proto);

}  // namespace penumbra
