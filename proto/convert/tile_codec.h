// Tiles of shadow texels: 64 × 64 texels, packed and unpacked without loss.
//
//   TileEncoder encoder;
//   v1::Tile tile = encoder.Encode(texels, column, row);
//   TileDecoder decoder;
//   absl::Status status = decoder.Decode(tile, texels_of_the_same_size);
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "penumbra/v1/artifact.pb.h"
#include "proto/convert/plane_codec.h"
#include "render/artifact/shadow_texels.h"

namespace penumbra {

inline constexpr uint32_t kTileSide = 64;  // texels

// How a W×H grid is cut into tiles.
struct TileGrid {
  uint32_t width = 0;
  uint32_t height = 0;

  uint32_t columns() const { return width / kTileSide + (width % kTileSide != 0); }
  uint32_t rows() const { return height / kTileSide + (height % kTileSide != 0); }
  size_t tile_count() const { return size_t{columns()} * rows(); }
};

// The texels of a tile.
struct TileRect {
  uint32_t x, y, width, height;
  size_t texels() const { return size_t{width} * height; }
};

inline TileGrid GridOf(const ShadowTexels& texels) {
  return {texels.visibility.width, texels.visibility.height};
}

// Whether radiance, if any, is told in the same codes.
bool HaveSameRadianceFormat(const ShadowTexels& a, const ShadowTexels& b);

// Whether a tile means the same in two grids of one size with the same planes: the same texels,
// or none visible in both, or all visible in both whatever the sample counts.
bool TilesEqual(const ShadowTexels& a, const ShadowTexels& b, uint32_t column, uint32_t row);

// Takes over the texels of `from`, of the same size and planes. Where sample counts differ, tiles
// that are all or none visible stay so, and others mean nothing.
void CopyTiles(const ShadowTexels& from, ShadowTexels& to);

// Keeps its compressor's memory from tile to tile. One thread at a time.
class TileEncoder {
 public:
  v1::Tile Encode(const ShadowTexels& texels, uint32_t column, uint32_t row);

 private:
  void GatherRadiance(const RadianceTexture& radiance, const TileRect& rect);

  PlanePacker packer_;
  std::vector<char> plane_;
};

// Keeps its decompressor's memory from tile to tile. One thread at a time.
class TileDecoder {
 public:
  // Writes a tile's texels into `texels`, whose size, sample count and planes are set.
  //
  // Errors  kInvalidArgument RANGE, CODEC, LENGTH; `texels` may then hold a part of the tile
  absl::Status Decode(const v1::Tile& tile, ShadowTexels& texels);

 private:
  absl::Status DecodeCounts(const v1::Tile& tile, const TileRect& rect, ShadowTexels& texels);
  absl::Status DecodeRadiance(const v1::Tile& tile, const TileRect& rect,
                              RadianceTexture& radiance);

  PlaneUnpacker unpacker_;
};

}  // namespace penumbra
