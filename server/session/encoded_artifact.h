// An artifact as bytes, made once for all who receive it.
//
//   ArtifactEncoder encoder;
//   auto next = encoder.Encode(previous.get(), update.artifact, sequence);
//   for (const EncodedTile& tile : next->tiles) if (tile.changed_at > acknowledged) …
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "grpcpp/support/slice.h"
#include "proto/convert/ldi_codec.h"
#include "proto/convert/tile_codec.h"
#include "proto/convert/volume_codec.h"
#include "proto/convert/width_codec.h"
#include "render/artifact/artifact.h"
#include "tbb/enumerable_thread_specific.h"

namespace penumbra {

// Slices share their bytes; each holds one field of v1::ArtifactUpdate with its tag, so that they
// can be strung together into a message.
struct EncodedTile {
  uint64_t changed_at = 0;  // the sequence number of the artifact that brought the present texels
  grpc::Slice bytes;
};

struct EncodedArtifact {
  std::shared_ptr<const Artifact> artifact;
  uint64_t sequence = 0;
  grpc::Slice header;
  uint64_t light_samples_changed_at = 0;
  grpc::Slice light_samples;
  // Row by row, and then the parts of the mask, which travel like tiles. Of a shadow volume mesh
  // all parts, volume by volume.
  std::vector<EncodedTile> tiles;
  // Of a shadow volume mesh: the names of its parts, one a tile; where each volume's begin, and
  // where the last ends; and what the header names.
  std::vector<std::string> part_names;
  std::vector<size_t> first_parts;
  std::vector<std::string> listed_heads;
};

// Any thread may use it, any number at a time; each keeps its compressor's memory.
class ArtifactEncoder {
 public:
  // Takes over from `previous` (which may be null) what is the same.
  std::shared_ptr<const EncodedArtifact> Encode(const EncodedArtifact* previous,
                                                std::shared_ptr<const Artifact> artifact,
                                                uint64_t sequence);

 private:
  void EncodeTexels(const ShadowTexels& texels, const EncodedArtifact* previous,
                    EncodedArtifact& encoded);
  static void EncodeCoverage(const ShadowTexels& texels, const EncodedArtifact* previous,
                             EncodedArtifact& encoded);
  void EncodeLayers(const AttenuationLdi& ldi, const EncodedArtifact* previous,
                    EncodedArtifact& encoded);
  void EncodeWidths(const ShadowWidthMap& map, const EncodedArtifact* previous,
                    EncodedArtifact& encoded);

  using KnownParts = std::unordered_map<std::string_view, const EncodedTile*>;
  void EncodeVolume(const ShadowVolume& volume, const KnownParts& known, EncodedArtifact& encoded);
  static void EncodeHeads(const KnownParts& known, EncodedArtifact& encoded);
  void EncodeVolumes(const ShadowVolumeMesh& mesh, const EncodedArtifact* previous,
                     EncodedArtifact& encoded);
  void EncodePayload(const ArtifactPayload& payload, const EncodedArtifact* previous,
                     EncodedArtifact& encoded);

  struct Packers {
    TileEncoder texels;
    LdiTileEncoder layers;
    WidthTileEncoder widths;
    VolumePartEncoder volumes;
  };
  tbb::enumerable_thread_specific<Packers> packers_;
};

}  // namespace penumbra
