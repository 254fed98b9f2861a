// Tiles of layered attenuation maps: 32 × 32 pixels with all their layers, packed and unpacked
// without loss.
//
//   LdiTileEncoder encoder;
//   for (const LdiTilePlace& place : LdiTilesOf(ldi)) Send(encoder.Encode(ldi, place));
//   LdiTiles tiles(ldi_without_layers);
//   absl::Status status = tiles.Add(tile);   // each, in any order
//   status = tiles.Finish(ldi_without_layers);
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "absl/status/status.h"
#include "penumbra/v1/artifact.pb.h"
#include "proto/convert/plane_codec.h"
#include "render/artifact/attenuation_ldi.h"

namespace penumbra {

// Pixels. A tile in which each has 128 layers takes 790 KB, which fits into a message.
inline constexpr uint32_t kLdiTileSide = 32;
inline constexpr uint32_t kMaxTileLayers = 128;  // a pixel
// Of a map: 1.6 GB, half as much again as servers make.
inline constexpr uint64_t kMaxMapLayers = uint64_t{1} << 28;

struct LdiTilePlace {
  uint32_t face, column, row;
};

// All tiles: face by face, row by row.
std::vector<LdiTilePlace> LdiTilesOf(const AttenuationLdi& ldi);

// Whether the tiles of two maps are at the same places of the same views.
bool HaveSameFaces(const AttenuationLdi& a, const AttenuationLdi& b);

// Whether a tile is the same in two maps of the same faces.
bool LdiTilesEqual(const AttenuationLdi& a, const AttenuationLdi& b, const LdiTilePlace& place);

// One thread at a time.
class LdiTileEncoder {
 public:
  v1::LdiTile Encode(const AttenuationLdi& ldi, const LdiTilePlace& place);

 private:
  PlanePacker packer_;
  std::vector<char> plane_;
};

// A map's tiles while they come in. Tiles are held once for all maps that they are the same in.
class LdiTiles {
 public:
  // None of the tiles of `ldi`, whose layers are not looked at, is here yet.
  explicit LdiTiles(const AttenuationLdi& ldi);

  // All tiles of `before`, of a map with the same faces, but for those whose counts are out of more
  // samples than there are now.
  LdiTiles(const AttenuationLdi& ldi, const LdiTiles& before);

  // Puts a tile in the place of what was there.
  //
  // Errors  kInvalidArgument RANGE, CODEC, LENGTH
  absl::Status Add(const v1::LdiTile& proto);

  size_t missing_count() const;

  // Gives `ldi` its layers; no tile may be missing.
  void Finish(AttenuationLdi& ldi) const;

 private:
  struct Tile {
    std::vector<uint8_t> layers;  // of each pixel
    std::vector<float> depths;
    std::vector<uint16_t> counts;
  };
  struct Face {
    uint32_t width, height, columns;
    bool from_infinity;
    std::vector<std::shared_ptr<const Tile>> tiles;
  };

  absl::Status Read(const v1::LdiTile& proto, bool from_infinity, Tile& tile);

  uint32_t sample_count_;
  std::vector<Face> faces_;
  uint64_t layers_ = 0;  // of all tiles
};

}  // namespace penumbra
