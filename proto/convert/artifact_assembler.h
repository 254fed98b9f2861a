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

#include "absl/status/statusor.h"
#include "penumbra/v1/artifact.pb.h"
#include "proto/convert/ldi_codec.h"
#include "proto/convert/texel_assembler.h"
#include "proto/convert/volume_assembler.h"
#include "proto/convert/width_codec.h"
#include "render/engine/engine.h"
#include "render/scene/scene_limits.h"

namespace penumbra {

class ArtifactAssembler {
 public:
  explicit ArtifactAssembler(const SceneLimits& limits = {}) : limits_(limits), volumes_(limits) {}

  // The update, once `message` completes it.
  //
  // Errors  those of FromProto, TexelAssembler, LdiTiles, WidthTiles and VolumeAssembler;
  //         kDataLoss INCOMPLETE: a tile or a part is missing. The subscription cannot go on after
  //         one.
  absl::StatusOr<std::optional<ArtifactUpdate>> Add(const v1::ArtifactUpdate& message);

  // What to acknowledge after a complete update.
  uint64_t sequence() const { return sequence_; }

 private:
  absl::Status Begin(const v1::ArtifactUpdate& message);
  absl::Status BeginSamples(const v1::ArtifactUpdate& message, bool starts_from_nothing);
  void BeginPayload(const Artifact* before);
  bool HasVolumes() const;
  absl::Status AddParts(const v1::ArtifactUpdate& message);
  absl::Status FinishPayload();
  absl::StatusOr<ArtifactUpdate> Finish(const v1::ArtifactUpdate& message);

  SceneLimits limits_;
  uint64_t sequence_ = 0;
  Revision revision_ = 0;           // of the update in the making
  bool in_update_ = false;          // between an update's first and last message
  std::shared_ptr<Artifact> next_;  // in the making; null: no artifact in this update
  TexelAssembler texels_;
  std::optional<LdiTiles> next_ldi_;       // of an attenuation LDI in the making
  std::optional<LdiTiles> ldi_;            // of the newest complete one
  std::optional<WidthTiles> next_widths_;  // of a shadow-width map in the making
  VolumeAssembler volumes_;
  std::shared_ptr<const Artifact> artifact_;  // the newest complete one
};

}  // namespace penumbra
