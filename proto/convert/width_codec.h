// Tiles of shadow-width maps: 64 × 64 texels, packed and unpacked without loss.
//
//   WidthTileEncoder encoder;
//   for (const WidthTilePlace& place : WidthTilesOf(map)) Send(encoder.Encode(map, place));
//   WidthTiles tiles(map_without_texels, before_or_null);
//   absl::Status status = tiles.Add(tile, map);   // each, in any order
//   if (tiles.missing_count() > 0) …
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "penumbra/v1/artifact.pb.h"
#include "proto/convert/plane_codec.h"
#include "render/artifact/shadow_width_map.h"

namespace penumbra {

// Texels. Four planes of a tile take 64 KB at most, before they are packed.
inline constexpr uint32_t kWidthTileSide = 64;

struct WidthTilePlace {
  uint32_t face, column, row;
};

// All tiles: face by face, row by row.
std::vector<WidthTilePlace> WidthTilesOf(const ShadowWidthMap& map);

// Whether the tiles of two maps are at the same places of the same views, and have the same planes.
bool HaveSameFaces(const ShadowWidthMap& a, const ShadowWidthMap& b);

// Whether a tile is the same in two maps of the same faces.
bool WidthTilesEqual(const ShadowWidthMap& a, const ShadowWidthMap& b, const WidthTilePlace& place);

// One thread at a time.
class WidthTileEncoder {
 public:
  v1::WidthTile Encode(const ShadowWidthMap& map, const WidthTilePlace& place);

 private:
  PlanePacker packer_;
  std::vector<float> floats_;
  std::vector<char> plane_;
};

// Which of a map's tiles have come in.
class WidthTiles {
 public:
  // Gives `map` its planes: those of `before`, where that is not null and has the same faces;
  // otherwise no tile is there yet.
  WidthTiles(ShadowWidthMap& map, const ShadowWidthMap* before);

  // Puts a tile in the place of what was there.
  //
  // Errors  kInvalidArgument RANGE, CODEC, LENGTH
  absl::Status Add(const v1::WidthTile& proto, ShadowWidthMap& map);

  size_t missing_count() const;

 private:
  struct Face {
    uint32_t columns, rows;
    std::vector<bool> has_tile;
  };
  std::vector<Face> faces_;
};

}  // namespace penumbra
