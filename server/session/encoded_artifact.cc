#include "server/session/encoded_artifact.h"

#include <string>
#include <string_view>
#include <unordered_map>
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
bool HaveSameGrid(const ShadowTexels& a, const ShadowTexels& b) {
  return a.visibility.width == b.visibility.width && a.visibility.height == b.visibility.height &&
         HaveSameRadianceFormat(a, b);
}

// Calls encode(i) for each of `count` tiles, on several threads where they are many.
template <typename Encode>
void ForEachTile(size_t count, Encode encode) {
  ParallelForRange(tbb::blocked_range<size_t>(0, count, kTilesPerTask),
                   [&](const tbb::blocked_range<size_t>& range) {
                     for (size_t i = range.begin(); i < range.end(); ++i) encode(i);
                   });
}

// Of a map that has faces: takes over from `previous` the tiles that are the same.
template <typename Map, typename Place, typename Equal, typename Encode>
void EncodeFaces(const Map& map, const std::vector<Place>& places, Equal equal,
                 const EncodedArtifact* previous, EncodedArtifact& encoded, Encode encode) {
  const auto* before = previous ? std::get_if<Map>(&previous->artifact->payload) : nullptr;
  if (before && !HaveSameFaces(*before, map)) before = nullptr;
  encoded.tiles.resize(places.size());
  ForEachTile(places.size(), [&](size_t i) {
    encoded.tiles[i] = before && equal(*before, map, places[i])
                           ? previous->tiles[i]
                           : EncodedTile{encoded.sequence, encode(places[i])};
  });
}

}  // namespace

void ArtifactEncoder::EncodeTexels(const ShadowTexels& texels, const EncodedArtifact* previous,
                                   EncodedArtifact& encoded) {
  const TileGrid grid = GridOf(texels);
  const ShadowTexels* before = previous ? TexelsOf(previous->artifact->payload) : nullptr;
  if (before && !HaveSameGrid(*before, texels)) before = nullptr;
  encoded.tiles.resize(grid.tile_count());
  ForEachTile(grid.tile_count(), [&](size_t i) {
    const auto column = static_cast<uint32_t>(i % grid.columns());
    const auto row = static_cast<uint32_t>(i / grid.columns());
    if (before && TilesEqual(*before, texels, column, row)) {
      encoded.tiles[i] = previous->tiles[i];
      return;
    }
    v1::ArtifactUpdate field;
    *field.add_tiles() = packers_.local().texels.Encode(texels, column, row);
    encoded.tiles[i] = {encoded.sequence, Bytes(field)};
  });
  EncodeCoverage(texels, previous, encoded);
}

void ArtifactEncoder::EncodeCoverage(const ShadowTexels& texels, const EncodedArtifact* previous,
                                     EncodedArtifact& encoded) {
  if (texels.coverage == nullptr) return;
  const ShadowTexels* texels_before = previous ? TexelsOf(previous->artifact->payload) : nullptr;
  const CoverageMask* before = texels_before ? texels_before->coverage.get() : nullptr;
  if (before && (before->width() != texels.coverage->width() ||
                 before->height() != texels.coverage->height())) {
    before = nullptr;
  }
  const size_t first = GridOf(texels).tile_count();
  for (uint32_t index = 0; index < CoveragePartCount(*texels.coverage); ++index) {
    if (before && CoveragePartsEqual(*before, *texels.coverage, index)) {
      encoded.tiles.push_back(previous->tiles[first + index]);
      continue;
    }
    v1::ArtifactUpdate field;
    *field.add_coverage() = EncodePart(*texels.coverage, index);
    encoded.tiles.push_back({encoded.sequence, Bytes(field)});
  }
}

void ArtifactEncoder::EncodeLayers(const AttenuationLdi& ldi, const EncodedArtifact* previous,
                                   EncodedArtifact& encoded) {
  EncodeFaces(ldi, LdiTilesOf(ldi), LdiTilesEqual, previous, encoded, [&](const auto& place) {
    v1::ArtifactUpdate field;
    *field.add_ldi_tiles() = packers_.local().layers.Encode(ldi, place);
    return Bytes(field);
  });
}

void ArtifactEncoder::EncodeWidths(const ShadowWidthMap& map, const EncodedArtifact* previous,
                                   EncodedArtifact& encoded) {
  EncodeFaces(map, WidthTilesOf(map), WidthTilesEqual, previous, encoded, [&](const auto& place) {
    v1::ArtifactUpdate field;
    *field.add_width_tiles() = packers_.local().widths.Encode(map, place);
    return Bytes(field);
  });
}

// The parts of a volume, and as many names. Those that `known` has are taken over.
void ArtifactEncoder::EncodeVolume(const ShadowVolume& volume, const KnownParts& known,
                                   EncodedArtifact& encoded) {
  const std::vector<VolumePartPlan> parts = PartsOf(volume);
  const size_t first = encoded.tiles.size();
  encoded.tiles.resize(first + parts.size());
  for (const VolumePartPlan& part : parts) encoded.part_names.push_back(part.name);
  ForEachTile(parts.size(), [&](size_t i) {
    if (const auto same = known.find(parts[i].name); same != known.end()) {
      encoded.tiles[first + i] = *same->second;
      return;
    }
    v1::ArtifactUpdate field;
    *field.add_volume_parts() = packers_.local().volumes.Encode(volume, parts[i]);
    encoded.tiles[first + i] = {encoded.sequence, Bytes(field)};
  });
}

// What the header names, with the lists that it takes before all that they name.
void ArtifactEncoder::EncodeHeads(const KnownParts& known, EncodedArtifact& encoded) {
  std::vector<std::string> heads;
  for (size_t i = 0; i + 1 < encoded.first_parts.size(); ++i) {
    heads.push_back(encoded.part_names[encoded.first_parts[i]]);
  }
  std::vector<VolumePartPlan> lists;
  encoded.listed_heads = ListNames(heads, lists);
  std::vector<EncodedTile> tiles;
  std::vector<std::string> names;
  for (const VolumePartPlan& list : lists) {
    v1::ArtifactUpdate field;
    *field.add_volume_parts() = EncodeList(list);
    const auto same = known.find(list.name);
    tiles.push_back(same != known.end() ? *same->second
                                        : EncodedTile{encoded.sequence, Bytes(field)});
    names.push_back(list.name);
  }
  encoded.tiles.insert(encoded.tiles.begin(), tiles.begin(), tiles.end());
  encoded.part_names.insert(encoded.part_names.begin(), names.begin(), names.end());
  for (size_t& first : encoded.first_parts) first += lists.size();
}

void ArtifactEncoder::EncodeVolumes(const ShadowVolumeMesh& mesh, const EncodedArtifact* previous,
                                    EncodedArtifact& encoded) {
  const auto* before =
      previous ? std::get_if<ShadowVolumeMesh>(&previous->artifact->payload) : nullptr;
  std::unordered_map<const ShadowVolume*, size_t> kept;  // volumes of the mesh before
  KnownParts known;
  for (size_t i = 0; before && i < before->volumes.size(); ++i) kept[before->volumes[i].get()] = i;
  for (size_t i = 0; before && i < previous->tiles.size(); ++i) {
    known[previous->part_names[i]] = &previous->tiles[i];
  }
  for (const auto& volume : mesh.volumes) {
    encoded.first_parts.push_back(encoded.tiles.size());
    const auto same = kept.find(volume.get());
    if (same == kept.end()) {
      EncodeVolume(*volume, known, encoded);
      continue;
    }
    for (size_t i = previous->first_parts[same->second];
         i < previous->first_parts[same->second + 1]; ++i) {
      encoded.tiles.push_back(previous->tiles[i]);
      encoded.part_names.push_back(previous->part_names[i]);
    }
  }
  encoded.first_parts.push_back(encoded.tiles.size());
  EncodeHeads(known, encoded);
}

void ArtifactEncoder::EncodePayload(const ArtifactPayload& payload, const EncodedArtifact* previous,
                                    EncodedArtifact& encoded) {
  if (const ShadowTexels* texels = TexelsOf(payload)) {
    EncodeTexels(*texels, previous, encoded);
  } else if (const auto* ldi = std::get_if<AttenuationLdi>(&payload)) {
    EncodeLayers(*ldi, previous, encoded);
  } else if (const auto* map = std::get_if<ShadowWidthMap>(&payload)) {
    EncodeWidths(*map, previous, encoded);
  } else {
    EncodeVolumes(std::get<ShadowVolumeMesh>(payload), previous, encoded);
  }
}

std::shared_ptr<const EncodedArtifact> ArtifactEncoder::Encode(
    const EncodedArtifact* previous, std::shared_ptr<const Artifact> artifact, uint64_t sequence) {
  auto encoded = std::make_shared<EncodedArtifact>();
  encoded->sequence = sequence;
  EncodePayload(artifact->payload, previous, *encoded);
  v1::ArtifactUpdate header;
  *header.mutable_header() = ToProto(*artifact);
  for (const std::string& name : encoded->listed_heads) {
    header.mutable_header()->mutable_shadow_volume_mesh()->add_volumes(name);
  }
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
  encoded->artifact = std::move(artifact);
  return encoded;
}

}  // namespace penumbra
