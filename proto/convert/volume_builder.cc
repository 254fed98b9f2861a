#include "proto/convert/volume_builder.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "proto/convert/float_plane.h"
#include "proto/convert/geometry_convert.h"
#include "proto/convert/texel_assembler.h"
#include "proto/convert/view_convert.h"
#include "proto/convert/volume_codec.h"
#include "render/scene/field_error.h"
#include "render/scene/scene.h"

namespace penumbra {
namespace {

// Whether it is somewhere: not the origin infinitely far, and not so far that it has no place.
bool IsPlace(const Vec4& vertex) {
  if (!IsFinite(Vec3(vertex)) || !std::isfinite(vertex.w) || vertex.w < 0) return false;
  return vertex.w > 0 ? IsFinite(Vec3(vertex) / vertex.w) : Vec3(vertex) != Vec3(0);
}

absl::Status Invalid(const std::string& field, const std::string& text) {
  return FieldError(absl::StatusCode::kInvalidArgument, "RANGE", field, text);
}

}  // namespace

absl::Status VolumeBuilder::AddFace(const v1::VolumeFace& proto, const std::string& field) {
  VolumeFace face{.map = {.view = FromProto(proto.view()), .depths = {}}};
  const LightView& view = face.map.view;
  if (auto status = CheckView(view, field + ".view", limits_); !status.ok()) return status;
  if (proto.border() != v1::VOLUME_BORDER_NOTHING && proto.border() != v1::VOLUME_BORDER_OTHERS) {
    return Invalid(field + ".border",
                   "found " + std::to_string(proto.border()) + ", need one that is known");
  }
  face.border = static_cast<VolumeBorder>(proto.border() - 1);
  samples_ += uint64_t{view.width} * view.height;
  if (samples_ > limits_.max_receiver_texels) {
    return Invalid(field, "found " + std::to_string(samples_) + " samples so far, need at most " +
                              std::to_string(limits_.max_receiver_texels));
  }
  face.map.depths.assign(size_t{view.width} * view.height, kNoDepth);
  has_tile_.emplace_back(size_t{VolumeTilesAlong(view.width)} * VolumeTilesAlong(view.height));
  volume_.faces.push_back(std::move(face));
  return absl::OkStatus();
}

absl::Status VolumeBuilder::Begin(const v1::VolumeHead& head) {
  const auto content = HashFromProto(head.content(), "volume_part.head.content");
  if (!content.ok()) return content.status();
  if (head.kind() == v1::VOLUME_KIND_UNSPECIFIED || !v1::VolumeKind_IsValid(head.kind())) {
    return Invalid("volume_part.head.kind",
                   "found " + std::to_string(head.kind()) + ", need one that is known");
  }
  if (!head.instance_id().empty()) {
    const auto status = CheckId(head.instance_id(), "volume_part.head.instance_id");
    if (!status.ok()) return status;
  }
  volume_.instance_id = head.instance_id();
  volume_.content = *content;
  volume_.kind = static_cast<VolumeKind>(head.kind() - 1);
  if (auto status = CheckFaceCount(head.faces_size(), "volume_part.head.faces"); !status.ok()) {
    return status;
  }
  if ((volume_.kind == VolumeKind::kObject) != (head.faces_size() == 0)) {
    return Invalid("volume_part.head.faces", "found " + std::to_string(head.faces_size()) +
                                                 ", need none of an object and some of others");
  }
  for (int i = 0; i < head.faces_size(); ++i) {
    const std::string field = "volume_part.head.faces[" + std::to_string(i) + "]";
    if (auto status = AddFace(head.faces(i), field); !status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::StatusOr<std::span<const float>> VolumeBuilder::Floats(const v1::FloatPlane& proto,
                                                             size_t count, const char* field) {
  const auto plane = unpacker_.Unpack(proto.codec(), proto.packed(), count * sizeof(float), field);
  if (!plane.ok()) return plane.status();
  FromPlane(*plane, floats_);
  return std::span<const float>(floats_);
}

absl::Status VolumeBuilder::AddDepths(const v1::VolumeDepths& proto) {
  const bool has_face = proto.face() < volume_.faces.size();
  DepthMap* const map = has_face ? &volume_.faces[proto.face()].map : nullptr;
  if (!map || proto.column() >= VolumeTilesAlong(map->view.width) ||
      proto.row() >= VolumeTilesAlong(map->view.height)) {
    return Invalid("volume_part.depths", "found face " + std::to_string(proto.face()) +
                                             ", column " + std::to_string(proto.column()) +
                                             " and row " + std::to_string(proto.row()) +
                                             ", need a tile of the volume's faces");
  }
  const auto [x, y, width, height] = VolumeTileAt(map->view, proto.column(), proto.row());
  const auto depths = Floats(proto.depths(), size_t{width} * height, "volume_part.depths.depths");
  if (!depths.ok()) return depths.status();
  const float least = map->view.from_infinity ? -kNoDepth : 0.0f;
  // What is not a number is not greater.
  if (!std::ranges::all_of(*depths, [&](float depth) { return depth > least; })) {
    return Invalid("volume_part.depths.depths", "found one that is no depth, need numbers");
  }
  for (uint32_t j = 0; j < height; ++j) {
    std::copy_n(depths->data() + size_t{j} * width, width,
                map->depths.data() + size_t{y + j} * map->view.width + x);
  }
  has_tile_[proto.face()]
           [size_t{proto.row()} * VolumeTilesAlong(map->view.width) + proto.column()] = true;
  return absl::OkStatus();
}

absl::Status VolumeBuilder::AddVertices(const v1::VolumeTriangles& proto) {
  const size_t count = proto.vertex_count();
  if (count > kMaxPartVertices || volume_.vertices.size() + count > kMaxVolumeVertices) {
    return Invalid("volume_part.triangles.vertex_count",
                   "found " + std::to_string(count) + " after " +
                       std::to_string(volume_.vertices.size()) + ", need at most " +
                       std::to_string(kMaxPartVertices) + " and " +
                       std::to_string(kMaxVolumeVertices) + " in all");
  }
  if (count == 0) return absl::OkStatus();
  const auto numbers = Floats(proto.vertices(), 4 * count, "volume_part.triangles.vertices");
  if (!numbers.ok()) return numbers.status();
  for (size_t i = 0; i < count; ++i) {
    const Vec4 vertex((*numbers)[i], (*numbers)[count + i], (*numbers)[2 * count + i],
                      (*numbers)[3 * count + i]);
    if (!IsPlace(vertex)) {
      return Invalid("volume_part.triangles.vertices",
                     "found one that is no place, need finite numbers and w >= 0");
    }
    volume_.vertices.push_back(vertex);
  }
  return absl::OkStatus();
}

absl::Status VolumeBuilder::AddWeights(const v1::VolumeTriangles& proto) {
  if (proto.weights_size() == 0) return absl::OkStatus();
  if (proto.are_the_casters() || 3 * proto.weights_size() != proto.corners_size()) {
    return Invalid("volume_part.triangles.weights",
                   "found " + std::to_string(proto.weights_size()) + " of " +
                       std::to_string(proto.corners_size()) +
                       " corners, need one a triangle that is no caster's");
  }
  for (const int32_t weight : proto.weights()) {
    if (weight < -128 || weight > 127) {
      return Invalid("volume_part.triangles.weights",
                     "found " + std::to_string(weight) + ", need -128 to 127");
    }
    volume_.weights.push_back(static_cast<int8_t>(weight));
  }
  return absl::OkStatus();
}

absl::Status VolumeBuilder::AddTriangles(const v1::VolumeTriangles& proto) {
  const bool is_object = volume_.kind == VolumeKind::kObject;
  if (!is_object && (proto.are_the_casters() || proto.weights_size() > 0)) {
    return Invalid("volume_part.triangles", "found weights or casters, need an object for these");
  }
  if (auto status = AddVertices(proto); !status.ok()) return status;
  auto& indices = proto.are_the_casters() ? volume_.caster_indices : volume_.indices;
  const auto corners = static_cast<size_t>(proto.corners_size());
  if (corners % 3 != 0 || corners > 3 * size_t{kMaxPartTriangles} ||
      indices.size() + corners > 3 * kMaxVolumeTriangles) {
    return Invalid("volume_part.triangles.corners",
                   "found " + std::to_string(corners) + " after " + std::to_string(indices.size()) +
                       ", need three a triangle, at most " + std::to_string(3 * kMaxPartTriangles) +
                       " and " + std::to_string(3 * kMaxVolumeTriangles) + " in all");
  }
  const size_t end = volume_.vertices.size();
  for (const uint32_t corner : proto.corners()) {
    if (corner < 1 || corner > end) {
      return Invalid("volume_part.triangles.corners", "found " + std::to_string(corner) +
                                                          ", need 1 to the " + std::to_string(end) +
                                                          " vertices so far");
    }
    if (proto.are_the_casters() && volume_.vertices[end - corner].w == 0) {
      return Invalid("volume_part.triangles.corners",
                     "found a caster's corner infinitely far, need one at a place");
    }
    indices.push_back(static_cast<uint32_t>(end - corner));
  }
  return AddWeights(proto);
}

absl::Status VolumeBuilder::Add(const v1::VolumePart& part) {
  if (part.has_depths()) return AddDepths(part.depths());
  if (part.has_triangles()) return AddTriangles(part.triangles());
  return Invalid("volume_part.content", "found neither depths nor triangles, need one of them");
}

absl::StatusOr<ShadowVolume> VolumeBuilder::Finish() {
  for (const auto& has : has_tile_) {
    if (const auto missing = std::ranges::count(has, false); missing > 0) {
      return Incomplete("found " + std::to_string(missing) + " tiles of depths missing, need all");
    }
  }
  if (!volume_.weights.empty() && volume_.weights.size() != volume_.triangle_count()) {
    return Invalid("volume_part.triangles.weights",
                   "found " + std::to_string(volume_.weights.size()) + " for " +
                       std::to_string(volume_.triangle_count()) + " triangles, need as many");
  }
  return std::move(volume_);
}

}  // namespace penumbra
