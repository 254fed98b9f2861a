// Puts the tiles of shadow texels, and the parts of their mask, together.
//
//   TexelAssembler assembler;
//   assembler.Begin(texels_before_or_null, next);
//   status = assembler.Add(message, next);   // each message of the update
//   status = assembler.Finish();
#pragma once

#include <memory>
#include <vector>

#include "absl/status/status.h"
#include "penumbra/v1/artifact.pb.h"
#include "proto/convert/tile_codec.h"
#include "render/artifact/shadow_texels.h"
#include "render/scene/coverage_mask.h"

namespace penumbra {

class TexelAssembler {
 public:
  // `next` takes over from `before`, null for none, what is told in the same way.
  void Begin(const ShadowTexels* before, ShadowTexels& next);

  // Errors  those of TileDecoder and DecodePart; kDataLoss INCOMPLETE: parts of no mask
  absl::Status Add(const v1::ArtifactUpdate& message, ShadowTexels& next);

  // Errors  kDataLoss INCOMPLETE: a tile or a part of the mask is missing
  absl::Status Finish();

 private:
  TileDecoder decoder_;
  std::vector<bool> has_tile_;  // where texels start from nothing, otherwise empty
  std::vector<bool> has_part_;  // likewise of a mask
  // In the making; null: as it was before, or no mask.
  std::shared_ptr<CoverageMask> next_coverage_;
};

// What the client holds is not all of the artifact.
absl::Status Incomplete(const std::string& text);

}  // namespace penumbra
