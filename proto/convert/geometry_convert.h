// Vectors, hashes and patches, both ways.
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "penumbra/v1/geometry.pb.h"
#include "render/math/vec.h"
#include "render/scene/camera.h"
#include "render/scene/content_hash.h"
#include "render/scene/receiver.h"

namespace penumbra {

v1::Vec3 ToProto(Vec3 v);
Vec3 FromProto(const v1::Vec3& v);
v1::DVec3 ToProto(DVec3 v);
DVec3 FromProto(const v1::DVec3& v);

// What an absent Parallelogram field stands for is that field's default in render/scene.
v1::Parallelogram ToProto(const Parallelogram& patch);
Parallelogram FromProto(const v1::Parallelogram& patch);

v1::Camera ToProto(const View& view);
// Without its aspect, and whatever its numbers are.
Camera CameraFromProto(const v1::Camera& camera);
// Errors  those of CheckView
absl::StatusOr<View> FromProto(const v1::Camera& camera);

// The 32 bytes of the hash.
std::string ToProto(const ContentHash& hash);
// Errors  kInvalidArgument LENGTH: not 32 bytes
absl::StatusOr<ContentHash> HashFromProto(const std::string& bytes, std::string_view field_path);

}  // namespace penumbra
