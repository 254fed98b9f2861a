#include "proto/convert/artifact_assembler.h"

#include <algorithm>
#include <string>
#include <utility>
#include <variant>

#include "proto/convert/artifact_convert.h"
#include "proto/convert/coverage_codec.h"
#include "proto/convert/status_convert.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

absl::Status Incomplete(const std::string& text) {
  return FieldError(absl::StatusCode::kDataLoss, "INCOMPLETE", "artifact_update", text);
}

SoftShadowTexture& TextureOf(Artifact& artifact) {
  return std::get<SoftShadowTexture>(artifact.payload);
}

// Takes over the texels of `from` where the grid and its planes are the same.
bool CopyTexels(const Artifact& from, Artifact& to) {
  const auto& before = std::get<SoftShadowTexture>(from.payload);
  auto& after = TextureOf(to);
  if (before.visibility.width != after.visibility.width ||
      before.visibility.height != after.visibility.height ||
      !HaveSameRadianceFormat(before, after)) {
    return false;
  }
  CopyTiles(before, after);
  return true;
}

}  // namespace

absl::StatusOr<std::optional<ArtifactUpdate>> ArtifactAssembler::Add(
    const v1::ArtifactUpdate& message) {
  if (!in_update_) {
    if (auto status = Begin(message); !status.ok()) return status;
  }
  if (auto status = AddTiles(message); !status.ok()) return status;
  if (auto status = AddCoverage(message); !status.ok()) return status;
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
  has_tile_.clear();
  has_part_.clear();
  next_coverage_ = nullptr;
  if (!message.has_header()) return absl::OkStatus();
  auto artifact = FromProto(message.header(), limits_);
  if (!artifact.ok()) return artifact.status();
  next_ = std::make_shared<Artifact>(*std::move(artifact));
  const bool starts_from_nothing = message.base_sequence() == 0 || !artifact_;
  if (starts_from_nothing || !CopyTexels(*artifact_, *next_)) {
    has_tile_.assign(GridOf(TextureOf(*next_)).tile_count(), false);
  }
  BeginCoverage(starts_from_nothing);
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

// A mask is taken over from an artifact with one of the same size, and otherwise begins empty.
void ArtifactAssembler::BeginCoverage(bool starts_from_nothing) {
  SoftShadowTexture& texture = TextureOf(*next_);
  if (texture.coverage == nullptr) return;
  if (!starts_from_nothing) {
    const auto& before = std::get<SoftShadowTexture>(artifact_->payload).coverage;
    if (before != nullptr && before->width() == texture.coverage->width() &&
        before->height() == texture.coverage->height()) {
      texture.coverage = before;
      return;
    }
  }
  has_part_.assign(CoveragePartCount(*texture.coverage), false);
}

absl::Status ArtifactAssembler::AddCoverage(const v1::ArtifactUpdate& message) {
  if (message.coverage_size() == 0) return absl::OkStatus();
  if (!next_ || !TextureOf(*next_).coverage) {
    return Incomplete("found a mask, need a header that has one before it");
  }
  auto& coverage = TextureOf(*next_).coverage;
  // What was handed out stays as it was.
  if (!next_coverage_) next_coverage_ = std::make_shared<CoverageMask>(*coverage);
  coverage = next_coverage_;
  for (const auto& part : message.coverage()) {
    if (auto status = DecodePart(part, *next_coverage_); !status.ok()) return status;
    if (!has_part_.empty()) has_part_[part.index()] = true;
  }
  return absl::OkStatus();
}

absl::Status ArtifactAssembler::AddTiles(const v1::ArtifactUpdate& message) {
  if (message.tiles_size() > 0 && !next_) {
    return Incomplete("found tiles, need a header before them");
  }
  for (const auto& tile : message.tiles()) {
    if (auto status = decoder_.Decode(tile, TextureOf(*next_)); !status.ok()) return status;
    if (has_tile_.empty()) continue;
    const TileGrid grid = GridOf(TextureOf(*next_));
    has_tile_[size_t{tile.row()} * grid.columns() + tile.column()] = true;
  }
  return absl::OkStatus();
}

absl::StatusOr<ArtifactUpdate> ArtifactAssembler::Finish(const v1::ArtifactUpdate& message) {
  sequence_ = message.update_sequence();
  if (message.has_error()) {
    return ArtifactUpdate{revision_, FromProto(message.error()), nullptr};
  }
  if (const auto missing = std::count(has_tile_.begin(), has_tile_.end(), false); missing > 0) {
    return Incomplete("found " + std::to_string(missing) + " tiles missing, need all");
  }
  if (std::count(has_part_.begin(), has_part_.end(), false) > 0) {
    return Incomplete("found parts of the mask missing, need all");
  }
  next_coverage_ = nullptr;
  if (next_) artifact_ = std::move(next_);
  next_ = nullptr;
  if (!artifact_) return Incomplete("found neither artifact nor error, need one of them");
  return ArtifactUpdate{revision_, absl::OkStatus(), artifact_};
}

}  // namespace penumbra
