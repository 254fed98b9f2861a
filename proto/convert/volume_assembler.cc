#include "proto/convert/volume_assembler.h"

#include <utility>

#include "proto/convert/texel_assembler.h"
#include "proto/convert/volume_builder.h"
#include "proto/convert/volume_codec.h"
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
  const Part part = before->second;
  return part->has_head() ? WantPartsOf(part->head()) : absl::OkStatus();
}

absl::Status VolumeAssembler::WantPartsOf(const v1::VolumeHead& head) {
  for (const std::string& name : head.parts()) {
    if (auto status = Want(name, "volume_part.head.parts"); !status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::Status VolumeAssembler::Begin(const v1::ShadowVolumeMesh& proto, bool starts_from_nothing) {
  next_.clear();
  if (starts_from_nothing) parts_.clear(), volumes_.clear();
  heads_.assign(proto.volumes().begin(), proto.volumes().end());
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
  return part.has_head() ? WantPartsOf(part.head()) : absl::OkStatus();
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
  for (const std::string& part_name : head->head().parts()) {
    const v1::VolumePart* const part = Find(part_name);
    if (part == nullptr) return Incomplete("found a part of a volume missing, need all");
    if (auto status = builder.Add(*part); !status.ok()) return status;
  }
  auto volume = builder.Finish();
  if (!volume.ok()) return volume.status();
  return std::make_shared<const ShadowVolume>(*std::move(volume));
}

absl::Status VolumeAssembler::Finish(ShadowVolumeMesh& mesh) {
  std::unordered_map<std::string, std::shared_ptr<const ShadowVolume>> volumes;
  uint64_t samples = 0;
  for (const std::string& name : heads_) {
    auto& volume = volumes[name];
    if (const auto before = volumes_.find(name); before != volumes_.end()) volume = before->second;
    if (volume == nullptr) {
      auto made = VolumeOf(name);
      if (!made.ok()) return made.status();
      volume = *std::move(made);
    }
    samples += volume->sample_count();
    if (samples > limits_.max_receiver_texels) {
      return Invalid("shadow_volume_mesh.volumes", "found " + std::to_string(samples) +
                                                       " samples or more, need at most " +
                                                       std::to_string(limits_.max_receiver_texels));
    }
    mesh.volumes.push_back(volume);
  }
  volumes_ = std::move(volumes);
  parts_ = std::move(next_);
  next_.clear();
  return absl::OkStatus();
}

}  // namespace penumbra
