#include "proto/convert/artifact_assembler.h"

#include <string>
#include <utility>
#include <variant>

#include "proto/convert/artifact_convert.h"
#include "proto/convert/status_convert.h"

namespace penumbra {

absl::StatusOr<std::optional<ArtifactUpdate>> ArtifactAssembler::Add(
    const v1::ArtifactUpdate& message) {
  if (!in_update_) {
    if (auto status = Begin(message); !status.ok()) return status;
  }
  if (auto status = AddParts(message); !status.ok()) return status;
  if (!message.end_of_update()) return std::nullopt;
  in_update_ = false;
  auto update = Finish(message);
  if (!update.ok()) return update.status();
  return std::optional<ArtifactUpdate>(*std::move(update));
}

absl::Status ArtifactAssembler::Begin(const v1::ArtifactUpdate& message) {
  in_update_ = true;
  revision_ = message.revision();
  next_ = nullptr;
  next_ldi_.reset();
  next_widths_.reset();
  if (!message.has_header()) return absl::OkStatus();
  auto artifact = FromProto(message.header(), limits_);
  if (!artifact.ok()) return artifact.status();
  next_ = std::make_shared<Artifact>(*std::move(artifact));
  const bool starts_from_nothing = message.base_sequence() == 0 || !artifact_;
  BeginPayload(starts_from_nothing ? nullptr : artifact_.get());
  if (HasVolumes()) {
    const auto status = volumes_.Begin(message.header().shadow_volume_mesh(), starts_from_nothing);
    if (!status.ok()) return status;
  }
  return BeginSamples(message, starts_from_nothing);
}

bool ArtifactAssembler::HasVolumes() const {
  return next_ != nullptr && std::holds_alternative<ShadowVolumeMesh>(next_->payload);
}

void ArtifactAssembler::BeginPayload(const Artifact* before) {
  if (HasVolumes()) return;
  if (ShadowTexels* texels = TexelsOf(next_->payload)) {
    texels_.Begin(before ? TexelsOf(before->payload) : nullptr, *texels);
    return;
  }
  if (auto* const map = std::get_if<ShadowWidthMap>(&next_->payload)) {
    next_widths_.emplace(*map, before ? std::get_if<ShadowWidthMap>(&before->payload) : nullptr);
    return;
  }
  const auto& ldi = std::get<AttenuationLdi>(next_->payload);
  const auto* ldi_before = before ? std::get_if<AttenuationLdi>(&before->payload) : nullptr;
  if (ldi_before && ldi_ && HaveSameFaces(*ldi_before, ldi)) {
    next_ldi_.emplace(ldi, *ldi_);
  } else {
    next_ldi_.emplace(ldi);
  }
}

absl::Status ArtifactAssembler::BeginSamples(const v1::ArtifactUpdate& message,
                                             bool starts_from_nothing) {
  if (message.has_light_samples()) {
    auto samples = DecodeLightSamples(message.light_samples());
    if (!samples.ok()) return samples.status();
    next_->header.light_samples = *std::move(samples);
  } else if (starts_from_nothing) {
    return Incomplete("found no light samples, need them where nothing came before");
  } else {
    next_->header.light_samples = artifact_->header.light_samples;
  }
  return absl::OkStatus();
}

absl::Status ArtifactAssembler::AddParts(const v1::ArtifactUpdate& message) {
  ShadowTexels* const texels = next_ ? TexelsOf(next_->payload) : nullptr;
  if (message.tiles_size() > 0 && !texels) {
    return Incomplete("found tiles, need a header of texels before them");
  }
  if (message.coverage_size() > 0 && !texels) {
    return Incomplete("found a mask, need a header that has one before it");
  }
  if (message.ldi_tiles_size() > 0 && !next_ldi_) {
    return Incomplete("found layers, need a header that has some before them");
  }
  if (message.width_tiles_size() > 0 && !next_widths_) {
    return Incomplete("found widths, need a header that has some before them");
  }
  if (message.volume_parts_size() > 0 && !HasVolumes()) {
    return Incomplete("found parts of volumes, need a header that has some before them");
  }
  if (texels) return texels_.Add(message, *texels);
  for (const auto& part : message.volume_parts()) {
    if (auto status = volumes_.Add(part); !status.ok()) return status;
  }
  for (const auto& tile : message.width_tiles()) {
    absl::Status status = next_widths_->Add(tile, std::get<ShadowWidthMap>(next_->payload));
    if (!status.ok()) return status;
  }
  for (const auto& tile : message.ldi_tiles()) {
    if (auto status = next_ldi_->Add(tile); !status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::Status ArtifactAssembler::FinishPayload() {
  if (auto* const mesh = std::get_if<ShadowVolumeMesh>(&next_->payload)) {
    return volumes_.Finish(*mesh);
  }
  if (!next_ldi_ && !next_widths_) return texels_.Finish();
  const size_t missing = next_ldi_ ? next_ldi_->missing_count() : next_widths_->missing_count();
  if (missing > 0) {
    return Incomplete("found " + std::to_string(missing) + " tiles missing, need all");
  }
  if (next_ldi_) {
    next_ldi_->Finish(std::get<AttenuationLdi>(next_->payload));
    ldi_ = std::exchange(next_ldi_, std::nullopt);
  }
  return absl::OkStatus();
}

absl::StatusOr<ArtifactUpdate> ArtifactAssembler::Finish(const v1::ArtifactUpdate& message) {
  sequence_ = message.update_sequence();
  if (message.has_error()) {
    absl::Status error = FromProto(message.error());
    if (error.ok()) return Incomplete("found an error whose code is that of none, need one");
    return ArtifactUpdate{revision_, std::move(error), nullptr};
  }
  if (next_) {
    if (auto status = FinishPayload(); !status.ok()) return status;
    artifact_ = std::move(next_);
  }
  next_ = nullptr;
  if (!artifact_) return Incomplete("found neither artifact nor error, need one of them");
  return ArtifactUpdate{revision_, absl::OkStatus(), artifact_};
}

}  // namespace penumbra
