#include "server/session/encoded_artifact.h"

#include <string>
#include <utility>
#include <variant>

#include "penumbra/v1/artifact.pb.h"
#include "proto/convert/artifact_convert.h"
#include "proto/convert/coverage_codec.h"
#include "render/math/parallel_for.h"
#include "tbb/blocked_range.h"

namespace penumbra {
namespace {

// A tile takes 5 µs to pack. Handing work to another thread takes about as much, but a hundred
// times more while other programs want the core: so small artifacts stay on one thread.
constexpr size_t kTilesPerTask = 32;

grpc::Slice Bytes(const v1::ArtifactUpdate& fields) {
  return grpc::Slice(fields.SerializeAsString());
}

// Whether the two can be compared tile by tile.
bool HaveSameGrid(const SoftShadowTexture& a, const SoftShadowTexture& b) {
  return a.visibility.width == b.visibility.width && a.visibility.height == b.visibility.height &&
         HaveSameRadianceFormat(a, b);
}

}  // namespace

void ArtifactEncoder::EncodeTiles(const SoftShadowTexture& texture, const EncodedArtifact* previous,
                                  EncodedArtifact& encoded) {
  const TileGrid grid = GridOf(texture);
  const auto* before =
      previous ? &std::get<SoftShadowTexture>(previous->artifact->payload) : nullptr;
  if (before && !HaveSameGrid(*before, texture)) before = nullptr;
  encoded.tiles.resize(grid.tile_count());
  const auto encode_tile = [&](size_t i) {
    const auto column = static_cast<uint32_t>(i % grid.columns());
    const auto row = static_cast<uint32_t>(i / grid.columns());
    if (before && TilesEqual(*before, texture, column, row)) {
      encoded.tiles[i] = previous->tiles[i];
      return;
    }
    v1::ArtifactUpdate field;
    *field.add_tiles() = tile_encoders_.local().Encode(texture, column, row);
    encoded.tiles[i] = {encoded.sequence, Bytes(field)};
  };
  ParallelForRange(tbb::blocked_range<size_t>(0, encoded.tiles.size(), kTilesPerTask),
                   [&](const tbb::blocked_range<size_t>& range) {
                     for (size_t i = range.begin(); i < range.end(); ++i) encode_tile(i);
                   });
}

void ArtifactEncoder::EncodeCoverage(const SoftShadowTexture& texture,
                                     const EncodedArtifact* previous, EncodedArtifact& encoded) {
  if (texture.coverage == nullptr) return;
  const auto* before =
      previous ? std::get<SoftShadowTexture>(previous->artifact->payload).coverage.get() : nullptr;
  if (before && (before->width() != texture.coverage->width() ||
                 before->height() != texture.coverage->height())) {
    before = nullptr;
  }
  const size_t first = GridOf(texture).tile_count();
  for (uint32_t index = 0; index < CoveragePartCount(*texture.coverage); ++index) {
    if (before && CoveragePartsEqual(*before, *texture.coverage, index)) {
      encoded.tiles.push_back(previous->tiles[first + index]);
      continue;
    }
    v1::ArtifactUpdate field;
    *field.add_coverage() = EncodePart(*texture.coverage, index);
    encoded.tiles.push_back({encoded.sequence, Bytes(field)});
  }
}

std::shared_ptr<const EncodedArtifact> ArtifactEncoder::Encode(
    const EncodedArtifact* previous, std::shared_ptr<const Artifact> artifact, uint64_t sequence) {
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
  std::visit(
      [&](const auto& payload) {
        EncodeTiles(payload, previous, *encoded);
        EncodeCoverage(payload, previous, *encoded);
      },
      artifact->payload);
  encoded->artifact = std::move(artifact);
  return encoded;
}

}  // namespace penumbra
