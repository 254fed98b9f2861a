// Tiles of soft shadow textures: 64 × 64 texels, packed and unpacked without loss.
//
//   TileEncoder encoder;
//   v1::Tile tile = encoder.Encode(texture, column, row);
//   TileDecoder decoder;
//   absl::Status status = decoder.Decode(tile, texture_of_the_same_size);
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "absl/status/status.h"
#include "penumbra/v1/artifact.pb.h"
#include "render/artifact/soft_shadow_texture.h"

struct ZSTD_CCtx_s;
struct ZSTD_DCtx_s;

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

inline TileGrid GridOf(const SoftShadowTexture& texture) {
  return {texture.visibility.width, texture.visibility.height};
}

// Whether radiance, if any, is told in the same codes.
bool HaveSameRadianceFormat(const SoftShadowTexture& a, const SoftShadowTexture& b);

// Whether a tile means the same in two textures of one size with the same planes: the same texels,
// or none visible in both, or all visible in both whatever the sample counts.
bool TilesEqual(const SoftShadowTexture& a, const SoftShadowTexture& b, uint32_t column,
                uint32_t row);

// Takes over the texels of `from`, of the same size and planes. Where sample counts differ, tiles
// that are all or none visible stay so, and others mean nothing.
void CopyTiles(const SoftShadowTexture& from, SoftShadowTexture& to);

// Keeps its compressor's memory from tile to tile. One thread at a time.
class TileEncoder {
 public:
  TileEncoder();
  v1::Tile Encode(const SoftShadowTexture& texture, uint32_t column, uint32_t row);

 private:
  void GatherRadiance(const RadianceTexture& radiance, const TileRect& rect);
  // Packs `plane_`, and leaves it as it is where that is shorter.
  v1::Codec Pack(std::string& packed);

  std::unique_ptr<ZSTD_CCtx_s, size_t (*)(ZSTD_CCtx_s*)> zstd_;
  std::vector<char> plane_;
};

// Keeps its decompressor's memory from tile to tile. One thread at a time.
class TileDecoder {
 public:
  TileDecoder();
  // Writes a tile's texels into `texture`, whose size, sample count and planes are set.
  //
  // Errors  kInvalidArgument RANGE, CODEC, LENGTH; `texture` may then hold a part of the tile
  absl::Status Decode(const v1::Tile& tile, SoftShadowTexture& texture);

 private:
  absl::Status DecodeCounts(const v1::Tile& tile, const TileRect& rect, SoftShadowTexture& texture);
  absl::Status DecodeRadiance(const v1::Tile& tile, const TileRect& rect,
                              RadianceTexture& radiance);
  // Unpacks into `plane_`, which must come out `size` bytes long.
  absl::Status Unpack(v1::Codec codec, const std::string& packed, size_t size, const char* name);

  std::unique_ptr<ZSTD_DCtx_s, size_t (*)(ZSTD_DCtx_s*)> zstd_;
  std::vector<char> plane_;
};

}  // namespace penumbra
