// Puts the messages of one subscription together into artifacts.
//
//   ArtifactAssembler assembler;
//   auto update = assembler.Add(response.artifact_update());
//   if (!update.ok()) …        // the server broke the protocol
//   if (update->has_value()) { Deliver(**update); Acknowledge(assembler.sequence()); }
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "penumbra/v1/artifact.pb.h"
#include "proto/convert/tile_codec.h"
#include "render/engine/engine.h"
#include "render/scene/scene_limits.h"

namespace penumbra {

class ArtifactAssembler {
 public:
  explicit ArtifactAssembler(const SceneLimits& limits = {}) : limits_(limits) {}

  // The update, once `message` completes it.
  //
  // Errors  those of FromProto, TileDecoder and DecodePart; kDataLoss INCOMPLETE: a tile or a part
  //         of the mask is missing. The subscription cannot go on after one.
  absl::StatusOr<std::optional<ArtifactUpdate>> Add(const v1::ArtifactUpdate& message);

  // What to acknowledge after a complete update.
  uint64_t sequence() const { return sequence_; }

 private:
  absl::Status Begin(const v1::ArtifactUpdate& message);
  void BeginCoverage(bool starts_from_nothing);
  absl::Status AddTiles(const v1::ArtifactUpdate& message);
  absl::Status AddCoverage(const v1::ArtifactUpdate& message);
  absl::StatusOr<ArtifactUpdate> Finish(const v1::ArtifactUpdate& message);

  SceneLimits limits_;
  TileDecoder decoder_;
  uint64_t sequence_ = 0;
  Revision revision_ = 0;           // of the update in the making
  bool in_update_ = false;          // between an update's first and last message
  std::shared_ptr<Artifact> next_;  // in the making; null: no artifact in this update
  std::vector<bool> has_tile_;      // of an artifact that starts from nothing, otherwise empty
  std::vector<bool> has_part_;      // likewise of a mask
  // In the making; null: as it was before, or no mask.
  std::shared_ptr<CoverageMask> next_coverage_;
  std::shared_ptr<const Artifact> artifact_;  // the newest complete one
};

}  // namespace penumbra
