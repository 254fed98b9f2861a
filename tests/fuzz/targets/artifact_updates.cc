#include "tests/fuzz/targets/artifact_updates.h"

#include "tests/fuzz/kit/require.h"
#include "tests/fuzz/targets/artifact_bytes.h"
#include "tests/fuzz/targets/whole_artifact.h"

namespace penumbra::fuzzing {
namespace {

constexpr SceneLimits kLimits{.max_receiver_side = 256, .max_receiver_texels = 1u << 15};

Step StepOf(const v1::ArtifactUpdate& update) { return {0, update.SerializeAsString()}; }

// A message for the header, and one for every tile or part.
Script InPieces(const v1::ArtifactUpdate& whole) {
  v1::ArtifactUpdate head = whole;
  head.clear_tiles();
  head.clear_coverage();
  head.clear_ldi_tiles();
  head.clear_width_tiles();
  head.clear_volume_parts();
  head.set_end_of_update(false);
  Script script{StepOf(head)};
  const auto add = [&script](const auto& list, auto put) {
    for (const auto& one : list) {
      v1::ArtifactUpdate piece;
      put(piece, one);
      script.push_back(StepOf(piece));
    }
  };
  add(whole.tiles(), [](auto& piece, const auto& one) { *piece.add_tiles() = one; });
  add(whole.coverage(), [](auto& piece, const auto& one) { *piece.add_coverage() = one; });
  add(whole.ldi_tiles(), [](auto& piece, const auto& one) { *piece.add_ldi_tiles() = one; });
  add(whole.width_tiles(), [](auto& piece, const auto& one) { *piece.add_width_tiles() = one; });
  add(whole.volume_parts(), [](auto& piece, const auto& one) { *piece.add_volume_parts() = one; });
  v1::ArtifactUpdate end;
  end.set_update_sequence(whole.update_sequence());
  end.set_end_of_update(true);
  script.push_back(StepOf(end));
  return script;
}

v1::ArtifactUpdate News(Revision revision) {
  v1::ArtifactUpdate update;
  update.set_revision(revision);
  update.set_end_of_update(true);
  return update;
}

}  // namespace

void ArtifactUpdates::Run(const Script& script) {
  assembler_ = std::make_unique<ArtifactAssembler>(kLimits);
  delivered_.clear();
  for (const Step& step : script) {
    v1::ArtifactUpdate message;
    if (message.ParseFromString(step.payload)) Receive(message);
  }
  for (const Delivered& one : delivered_) {
    Require(BytesOfArtifact(*one.artifact) == one.bytes, "what was handed out stays as it was");
  }
}

void ArtifactUpdates::Receive(const v1::ArtifactUpdate& message) {
  const auto update = assembler_->Add(message);
  Count(update.ok());
  if (!update.ok()) {
    RequireRefusal(update.status());
    // The subscription has ended, and another begins.
    assembler_ = std::make_unique<ArtifactAssembler>(kLimits);
    return;
  }
  Require(update->has_value() == message.end_of_update(), "an update ends with its last message");
  if (!update->has_value() || !(*update)->status.ok()) return;
  RequireSound((*update)->artifact, kLimits);
  delivered_.push_back({(*update)->artifact, BytesOfArtifact(*(*update)->artifact)});
}

std::vector<Seed> ArtifactUpdates::SeedsOf(const std::string& name, const Artifact& before,
                                           const Artifact& after) {
  const v1::ArtifactUpdate first = WholeUpdate(before, 1);
  v1::ArtifactUpdate second = WholeUpdate(after, 2);
  second.set_base_sequence(1);
  const v1::ArtifactUpdate raw = WithRawPlanes(first), raw_second = WithRawPlanes(second);
  return {
      {name, {StepOf(first)}},
      {name + "-raw", {StepOf(raw)}},
      {name + "-change", {StepOf(raw), StepOf(News(7)), StepOf(raw_second)}},
      {name + "-pieces", InPieces(raw)},
  };
}

}  // namespace penumbra::fuzzing
