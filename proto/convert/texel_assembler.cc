#include "proto/convert/texel_assembler.h"

#include <algorithm>
#include <string>

#include "proto/convert/coverage_codec.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

// Takes over the texels of `before` where the grid and its planes are the same.
bool CopyTexels(const ShadowTexels& before, ShadowTexels& next) {
  if (before.visibility.width != next.visibility.width ||
      before.visibility.height != next.visibility.height || !HaveSameRadianceFormat(before, next)) {
    return false;
  }
  CopyTiles(before, next);
  return true;
}

// Likewise a mask of the same size.
bool CopyCoverage(const ShadowTexels& before, ShadowTexels& next) {
  if (before.coverage == nullptr || before.coverage->width() != next.coverage->width() ||
      before.coverage->height() != next.coverage->height()) {
    return false;
  }
  next.coverage = before.coverage;
  return true;
}

}  // namespace

absl::Status Incomplete(const std::string& text) {
  return FieldError(absl::StatusCode::kDataLoss, "INCOMPLETE", "artifact_update", text);
}

void TexelAssembler::Begin(const ShadowTexels* before, ShadowTexels& next) {
  has_tile_.clear();
  has_part_.clear();
  next_coverage_ = nullptr;
  if (before == nullptr || !CopyTexels(*before, next)) {
    has_tile_.assign(GridOf(next).tile_count(), false);
  }
  if (next.coverage == nullptr) return;
  if (before == nullptr || !CopyCoverage(*before, next)) {
    has_part_.assign(CoveragePartCount(*next.coverage), false);
  }
}

absl::Status TexelAssembler::Add(const v1::ArtifactUpdate& message, ShadowTexels& next) {
  for (const auto& tile : message.tiles()) {
    if (auto status = decoder_.Decode(tile, next); !status.ok()) return status;
    if (has_tile_.empty()) continue;
    has_tile_[size_t{tile.row()} * GridOf(next).columns() + tile.column()] = true;
  }
  if (message.coverage_size() == 0) return absl::OkStatus();
  if (!next.coverage) return Incomplete("found a mask, need a header that has one before it");
  // What was handed out stays as it was.
  if (!next_coverage_) next_coverage_ = std::make_shared<CoverageMask>(*next.coverage);
  next.coverage = next_coverage_;
  for (const auto& part : message.coverage()) {
    if (auto status = DecodePart(part, *next_coverage_); !status.ok()) return status;
    if (!has_part_.empty()) has_part_[part.index()] = true;
  }
  return absl::OkStatus();
}

absl::Status TexelAssembler::Finish() {
  if (const auto missing = std::count(has_tile_.begin(), has_tile_.end(), false); missing > 0) {
    return Incomplete("found " + std::to_string(missing) + " tiles missing, need all");
  }
  if (std::count(has_part_.begin(), has_part_.end(), false) > 0) {
    return Incomplete("found parts of the mask missing, need all");
  }
  next_coverage_ = nullptr;
  return absl::OkStatus();
}

}  // namespace penumbra
