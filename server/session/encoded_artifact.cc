#include "server/session/encoded_artifact.h"

#include <string>
#include <utility>
#include <variant>

#include "penumbra/v1/artifact.pb.h"
#include "proto/convert/artifact_convert.h"

namespace penumbra {
namespace {

grpc::Slice Bytes(const v1::ArtifactUpdate& fields) {
  return grpc::Slice(fields.SerializeAsString());
}

// Whether the two can be compared tile by tile.
bool HaveSameGrid(const SoftShadowTexture& a, const SoftShadowTexture& b) {
  return a.visibility.width == b.visibility.width && a.visibility.height == b.visibility.height &&
         a.radiance.has_value() == b.radiance.has_value();
}

void EncodeTiles(const SoftShadowTexture& texture, const EncodedArtifact* previous,
                 TileEncoder& encoder, EncodedArtifact& encoded) {
  const TileGrid grid = GridOf(texture);
  const auto* before =
      previous ? &std::get<SoftShadowTexture>(previous->artifact->payload) : nullptr;
  if (before && !HaveSameGrid(*before, texture)) before = nullptr;
  encoded.tiles.reserve(grid.tile_count());
  v1::ArtifactUpdate field;
  for (uint32_t row = 0; row < grid.rows(); ++row) {
    for (uint32_t column = 0; column < grid.columns(); ++column) {
      if (before && TilesEqual(*before, texture, column, row)) {
        encoded.tiles.push_back(previous->tiles[encoded.tiles.size()]);
        continue;
      }
      field.clear_tiles();
      *field.add_tiles() = encoder.Encode(texture, column, row);
      encoded.tiles.push_back({encoded.sequence, Bytes(field)});
    }
  }
}

}  // namespace

std::shared_ptr<const EncodedArtifact> Encode(const EncodedArtifact* previous,
                                              std::shared_ptr<const Artifact> artifact,
                                              uint64_t sequence, TileEncoder& encoder) {
  auto encoded = std::make_shared<EncodedArtifact>();
  encoded->sequence = sequence;
  v1::ArtifactUpdate header;
  *header.mutable_header() = ToProto(*artifact);
  encoded->header = Bytes(header);
  if (previous && previous->artifact->header.light_samples == artifact->header.light_samples) {
    encoded->light_samples_changed_at = previous->light_samples_changed_at;
    encoded->light_samples = previous->light_samples;
  } else {
    v1::ArtifactUpdate samples;
    samples.set_light_samples(EncodeLightSamples(artifact->header.light_samples));
    encoded->light_samples_changed_at = sequence;
    encoded->light_samples = Bytes(samples);
  }
  std::visit([&](const auto& payload) { EncodeTiles(payload, previous, encoder, *encoded); },
             artifact->payload);
  encoded->artifact = std::move(artifact);
  return encoded;
}

}  // namespace penumbra
