// What a shadow volume mesh is, apart from its parts (volume_codec.h), both ways.
#pragma once

#include "absl/status/statusor.h"
#include "penumbra/v1/artifact.pb.h"
#include "render/artifact/shadow_volume_mesh.h"

namespace penumbra {

// Without the names of its volumes, which are its encoder's to say.
v1::ShadowVolumeMesh ToProto(const ShadowVolumeMesh& mesh);

// The mesh without volumes.
//
// Errors  kInvalidArgument RANGE: a number that cannot be; those of the light's FromProto
absl::StatusOr<ShadowVolumeMesh> FromProto(const v1::ShadowVolumeMesh& proto);

}  // namespace penumbra
