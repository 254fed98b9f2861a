// Instances.

#include <string>

#include "proto/convert/geometry_convert.h"
#include "proto/convert/scene_convert.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

constexpr int kAffineColumns = 4;
constexpr int kAffineRows = 3;

template <typename T>
absl::StatusOr<std::shared_ptr<const T>> Found(std::shared_ptr<const T> blob,
                                               const ContentHash& hash, const std::string& path) {
  if (blob) return blob;
  return FieldError(absl::StatusCode::kFailedPrecondition, "MISSING_BLOB", path,
                    "found " + hash.hex() + ", which is not here, need an uploaded blob");
}

absl::Status ReadTransform(const v1::Instance& proto, const std::string& path, Affine& affine) {
  const int found = proto.world_from_mesh_size();
  if (found == 0) return absl::OkStatus();
  if (found != kAffineColumns * kAffineRows) {
    return FieldError(absl::StatusCode::kInvalidArgument, "LENGTH", path + ".world_from_mesh",
                      "found " + std::to_string(found) + " numbers, need 12 or none");
  }
  for (int column = 0; column < kAffineColumns; ++column) {
    for (int row = 0; row < kAffineRows; ++row) {
      affine[column][row] = proto.world_from_mesh(column * kAffineRows + row);
    }
  }
  return absl::OkStatus();
}

}  // namespace

v1::Instance ToProto(const Instance& instance) {
  v1::Instance proto;
  proto.set_id(instance.id);
  if (instance.mesh) proto.set_mesh_hash(ToProto(instance.mesh->id()));
  for (int column = 0; column < kAffineColumns; ++column) {
    for (int row = 0; row < kAffineRows; ++row) {
      proto.add_world_from_mesh(instance.world_from_mesh[column][row]);
    }
  }
  proto.set_casts(instance.casts);
  proto.set_receives(instance.receives);
  *proto.mutable_color() = ToProto(instance.color);
  if (instance.alpha_mask) proto.set_alpha_mask_hash(ToProto(instance.alpha_mask->id()));
  proto.set_alpha_cutoff(instance.alpha_cutoff);
  return proto;
}

absl::StatusOr<Instance> FromProto(const v1::Instance& proto, const BlobSource& blobs,
                                   std::string_view field_path) {
  const std::string path(field_path);
  Instance instance;
  instance.id = proto.id();
  const auto mesh_hash = HashFromProto(proto.mesh_hash(), path + ".mesh_hash");
  if (!mesh_hash.ok()) return mesh_hash.status();
  auto mesh = Found(blobs.FindMesh(*mesh_hash), *mesh_hash, path + ".mesh_hash");
  if (!mesh.ok()) return mesh.status();
  instance.mesh = *std::move(mesh);
  if (auto status = ReadTransform(proto, path, instance.world_from_mesh); !status.ok()) {
    return status;
  }
  if (proto.has_casts()) instance.casts = proto.casts();
  if (proto.has_receives()) instance.receives = proto.receives();
  if (proto.has_color()) instance.color = FromProto(proto.color());
  if (proto.has_alpha_cutoff()) instance.alpha_cutoff = proto.alpha_cutoff();
  if (!proto.alpha_mask_hash().empty()) {
    const auto mask_hash = HashFromProto(proto.alpha_mask_hash(), path + ".alpha_mask_hash");
    if (!mask_hash.ok()) return mask_hash.status();
    auto mask = Found(blobs.FindMask(*mask_hash), *mask_hash, path + ".alpha_mask_hash");
    if (!mask.ok()) return mask.status();
    instance.alpha_mask = *std::move(mask);
  }
  return instance;
}

}  // namespace penumbra
