#include "proto/convert/volume_assembler.h"

#include <utility>

#include "proto/convert/texel_assembler.h"
#include "proto/convert/volume_builder.h"
#include "proto/convert/volume_codec.h"
#include "render/artifact/light_extent.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

// Of one mesh; more than any that a server makes.
constexpr size_t kMaxNames = size_t{1} << 20;

absl::Status Invalid(const std::string& field, const std::string& text) {
  return FieldError(absl::StatusCode::kInvalidArgument, "RANGE", field, text);
}

}  // namespace

absl::Status VolumeAssembler::Want(const std::string& name, const std::string& field) {
  if (name.size() != kPartNameBytes) {
    return FieldError(
        absl::StatusCode::kInvalidArgument, "LENGTH", field,
        "found " + std::to_string(name.size()) + " bytes, need " + std::to_string(kPartNameBytes));
  }
  const auto [entry, is_new] = next_.try_emplace(name);
  if (!is_new) return absl::OkStatus();
  if (next_.size() > kMaxNames) {
    return Invalid(field, "found more than " + std::to_string(kMaxNames) + " parts, need fewer");
  }
  const auto before = parts_.find(name);
  if (before == parts_.end()) return absl::OkStatus();
  entry->second = before->second;
  const Part part = before->second;  // entries move
  return WantPartsOf(*part);
}

absl::Status VolumeAssembler::WantPartsOf(const v1::VolumePart& part) {
  for (const std::string& name : part.head().parts()) {
    if (auto status = Want(name, "volume_part.head.parts"); !status.ok()) return status;
  }
  for (const std::string& name : part.names().names()) {
    if (auto status = Want(name, "volume_part.names.names"); !status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<std::string>> VolumeAssembler::WithoutLists(const Names& names) const {
  std::vector<std::string> all;
  for (const std::string& name : names) {
    const v1::VolumePart* const part = Find(name);
    if (part == nullptr) return Incomplete("found a part of a volume missing, need all");
    if (part->has_names()) {
      all.insert(all.end(), part->names().names().begin(), part->names().names().end());
    } else {
      all.push_back(name);
    }
    if (all.size() > kMaxNames) {
      return Invalid("volume_part.names.names",
                     "found more than " + std::to_string(kMaxNames) + " in all, need fewer");
    }
  }
  return all;
}

absl::Status VolumeAssembler::Begin(const v1::ShadowVolumeMesh& proto, bool starts_from_nothing) {
  next_.clear();
  if (starts_from_nothing) parts_.clear(), volumes_.clear();
  heads_ = proto.volumes();
  for (const std::string& name : heads_) {
    if (auto status = Want(name, "shadow_volume_mesh.volumes"); !status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::Status VolumeAssembler::Add(const v1::VolumePart& part) {
  const auto entry = next_.find(part.name());
  if (entry == next_.end()) {
    return Invalid("volume_part.name", "found one that nothing names, need one that a head does");
  }
  if (entry->second != nullptr) return absl::OkStatus();  // named twice, or held already
  entry->second = std::make_shared<v1::VolumePart>(part);
  return WantPartsOf(part);
}

const v1::VolumePart* VolumeAssembler::Find(const std::string& name) const {
  const auto entry = next_.find(name);
  return entry == next_.end() ? nullptr : entry->second.get();
}

absl::StatusOr<std::shared_ptr<const ShadowVolume>> VolumeAssembler::VolumeOf(
    const std::string& name) {
  const v1::VolumePart* const head = Find(name);
  if (head == nullptr) return Incomplete("found a volume missing, need all");
  if (!head->has_head()) return Invalid("shadow_volume_mesh.volumes", "found one that is no head");
  VolumeBuilder builder(limits_);
  if (auto status = builder.Begin(head->head()); !status.ok()) return status;
  const auto names = WithoutLists(head->head().parts());
  if (!names.ok()) return names.status();
  for (const std::string& part_name : *names) {
    const v1::VolumePart* const part = Find(part_name);
    if (part == nullptr) return Incomplete("found a part of a volume missing, need all");
    if (auto status = builder.Add(*part); !status.ok()) return status;
  }
  auto volume = builder.Finish();
  if (!volume.ok()) return volume.status();
  return std::make_shared<const ShadowVolume>(*std::move(volume));
}

absl::Status VolumeAssembler::CheckWhole(const ShadowVolumeMesh& mesh) const {
  const bool is_distant = PlaceOfMiddle(mesh.light).w == 0;
  uint64_t samples = 0, triangles = 0, vertices = 0;
  for (const auto& volume : mesh.volumes) {
    for (const VolumeFace& face : volume->faces) {
      if (face.map.view.from_infinity == is_distant) continue;
      return Invalid("volume_part.head.faces",
                     "found a view that is not from the light, need one from there");
    }
    samples += volume->sample_count();
    triangles += volume->weighed_triangle_count() + volume->caster_indices.size() / 3;
    vertices += volume->vertices.size();
  }
  if (samples <= limits_.max_receiver_texels && triangles <= kMaxVolumeTriangles &&
      vertices <= kMaxVolumeVertices) {
    return absl::OkStatus();
  }
  return Invalid("shadow_volume_mesh.volumes",
                 "found " + std::to_string(samples) + " samples, " + std::to_string(triangles) +
                     " triangles and " + std::to_string(vertices) + " vertices, need at most " +
                     std::to_string(limits_.max_receiver_texels) + ", " +
                     std::to_string(kMaxVolumeTriangles) + " and " +
                     std::to_string(kMaxVolumeVertices));
}

absl::Status VolumeAssembler::Finish(ShadowVolumeMesh& mesh) {
  const auto names = WithoutLists(heads_);
  if (!names.ok()) return names.status();
  std::unordered_map<std::string, std::shared_ptr<const ShadowVolume>> volumes;
  for (const std::string& name : *names) {
    const auto [entry, is_new] = volumes.try_emplace(name);
    if (!is_new) return Invalid("shadow_volume_mesh.volumes", "found one twice, need each once");
    const auto before = volumes_.find(name);
    if (before != volumes_.end()) {
      entry->second = before->second;
    } else {
      auto made = VolumeOf(name);
      if (!made.ok()) return made.status();
      entry->second = *std::move(made);
    }
    mesh.volumes.push_back(entry->second);
    // Before the next is made.
    if (mesh.volumes.size() % 64 == 0 || mesh.volumes.back()->bytes() > (size_t{1} << 20)) {
      if (auto status = CheckWhole(mesh); !status.ok()) return status;
    }
  }
  if (auto status = CheckWhole(mesh); !status.ok()) return status;
  volumes_ = std::move(volumes);
  parts_ = std::move(next_);
  next_.clear();
  return absl::OkStatus();
}

}  // namespace penumbra
