#include "proto/convert/tile_codec.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <optional>
#include <span>
#include <string>

#include "render/scene/field_error.h"

namespace penumbra {
namespace {

static_assert(std::endian::native == std::endian::little, "planes are copied as they lie");
static_assert(sizeof(Vec3) == 3 * sizeof(float));

using Rect = TileRect;

Rect RectOf(TileGrid grid, uint32_t column, uint32_t row) {
  const uint32_t x = column * kTileSide;
  const uint32_t y = row * kTileSide;
  return {x, y, std::min(kTileSide, grid.width - x), std::min(kTileSide, grid.height - y)};
}

size_t BytesPerCount(const ShadowTexels& texels) { return texels.has_byte_counts() ? 1 : 2; }

template <typename T>
bool RowsEqual(const std::vector<T>& a, const std::vector<T>& b, uint32_t stride, Rect rect) {
  for (uint32_t j = 0; j < rect.height; ++j) {
    const size_t start = size_t{rect.y + j} * stride + rect.x;
    if (std::memcmp(&a[start], &b[start], rect.width * sizeof(T)) != 0) return false;
  }
  return true;
}

void GatherCounts(const VisibilityMap& map, Rect rect, size_t bytes_per_count,
                  std::vector<char>& plane) {
  plane.resize(rect.texels() * bytes_per_count);
  char* out = plane.data();
  for (uint32_t j = 0; j < rect.height; ++j) {
    const uint16_t* row = &map.counts[size_t{rect.y + j} * map.width + rect.x];
    if (bytes_per_count == 1) {
      for (uint32_t i = 0; i < rect.width; ++i) out[i] = static_cast<char>(row[i]);
    } else {
      std::memcpy(out, row, rect.width * sizeof(uint16_t));
    }
    out += rect.width * bytes_per_count;
  }
}

// How a tile in which all or none of the samples are visible is told; none for any other tile.
std::optional<v1::Codec> UniformCodec(const VisibilityMap& map, Rect rect) {
  const uint16_t first = map.counts[size_t{rect.y} * map.width + rect.x];
  if (first != 0 && first != map.sample_count) return std::nullopt;
  for (uint32_t j = 0; j < rect.height; ++j) {
    const uint16_t* row = &map.counts[size_t{rect.y + j} * map.width + rect.x];
    uint32_t differences = 0;
    for (uint32_t i = 0; i < rect.width; ++i) differences |= static_cast<uint32_t>(row[i] ^ first);
    if (differences != 0) return std::nullopt;
  }
  return first == 0 ? v1::CODEC_NONE_VISIBLE : v1::CODEC_ALL_VISIBLE;
}

void FillCounts(uint32_t count, Rect rect, VisibilityMap& map) {
  for (uint32_t j = 0; j < rect.height; ++j) {
    uint16_t* row = &map.counts[size_t{rect.y + j} * map.width + rect.x];
    std::fill(row, row + rect.width, static_cast<uint16_t>(count));
  }
}

// False where a count is larger than the number of samples.
bool ScatterCounts(std::span<const char> plane, Rect rect, size_t bytes_per_count,
                   VisibilityMap& map) {
  const char* in = plane.data();
  uint32_t largest = 0;
  for (uint32_t j = 0; j < rect.height; ++j) {
    uint16_t* row = &map.counts[size_t{rect.y + j} * map.width + rect.x];
    if (bytes_per_count == 1) {
      for (uint32_t i = 0; i < rect.width; ++i) row[i] = static_cast<uint8_t>(in[i]);
    } else {
      std::memcpy(row, in, rect.width * sizeof(uint16_t));
    }
    for (uint32_t i = 0; i < rect.width; ++i) largest = std::max<uint32_t>(largest, row[i]);
    in += rect.width * bytes_per_count;
  }
  return largest <= map.sample_count;
}

// Calls copy(texel, texel_of_tile) with the first texel of each of the tile's rows.
template <typename Copy>
void ForRowsOfRadiance(uint32_t stride, Rect rect, Copy copy) {
  for (uint32_t j = 0; j < rect.height; ++j) {
    copy(size_t{rect.y + j} * stride + rect.x, size_t{j} * rect.width);
  }
}

// The k-th code of a plane, of one or two bytes.
void PutCode(size_t bytes, size_t k, uint16_t code, std::vector<char>& plane) {
  std::memcpy(&plane[k * bytes], &code, bytes);
}

uint16_t CodeAt(size_t bytes, size_t k, std::span<const char> plane) {
  uint16_t code = 0;
  std::memcpy(&code, &plane[k * bytes], bytes);
  return code;
}

absl::Status Invalid(const char* reason, const std::string& field, const std::string& text) {
  return FieldError(absl::StatusCode::kInvalidArgument, reason, field, text);
}

}  // namespace

bool HaveSameRadianceFormat(const ShadowTexels& a, const ShadowTexels& b) {
  if (!a.radiance || !b.radiance) return a.radiance.has_value() == b.radiance.has_value();
  return a.radiance->format == b.radiance->format && a.radiance->scale == b.radiance->scale;
}

bool TilesEqual(const ShadowTexels& a, const ShadowTexels& b, uint32_t column, uint32_t row) {
  const Rect rect = RectOf(GridOf(a), column, row);
  const uint32_t stride = a.visibility.width;
  if (a.visibility.sample_count != b.visibility.sample_count) {
    const auto uniform = UniformCodec(a.visibility, rect);
    if (!uniform || uniform != UniformCodec(b.visibility, rect)) return false;
  } else if (!RowsEqual(a.visibility.counts, b.visibility.counts, stride, rect)) {
    return false;
  }
  return !a.radiance || RowsEqual(a.radiance->texels, b.radiance->texels, stride, rect);
}

void CopyTiles(const ShadowTexels& from, ShadowTexels& to) {
  to.visibility.counts = from.visibility.counts;
  if (to.radiance) to.radiance->texels = from.radiance->texels;
  const uint32_t all_before = from.visibility.sample_count;
  const uint32_t all = to.visibility.sample_count;
  if (all == all_before) return;
  for (uint16_t& count : to.visibility.counts) {
    count = static_cast<uint16_t>(count == all_before ? all : 0);
  }
}

v1::Tile TileEncoder::Encode(const ShadowTexels& texels, uint32_t column, uint32_t row) {
  v1::Tile tile;
  tile.set_column(column);
  tile.set_row(row);
  const Rect rect = RectOf(GridOf(texels), column, row);
  if (const auto uniform = UniformCodec(texels.visibility, rect)) {
    tile.set_counts_codec(*uniform);
  } else {
    GatherCounts(texels.visibility, rect, BytesPerCount(texels), plane_);
    tile.set_counts_codec(packer_.Pack(plane_, *tile.mutable_counts()));
  }
  if (texels.radiance) {
    GatherRadiance(*texels.radiance, rect);
    tile.set_radiance_codec(packer_.Pack(plane_, *tile.mutable_radiance()));
  }
  return tile;
}

void TileEncoder::GatherRadiance(const RadianceTexture& radiance, const TileRect& rect) {
  const size_t bytes = BytesPerChannel(radiance.format);
  plane_.resize(rect.texels() * 3 * bytes);
  const bool is_coded = radiance.format != RadianceFormat::kFloat32;
  const RadianceCodec codec(radiance.format, radiance.scale);
  ForRowsOfRadiance(radiance.width, rect, [&](size_t texel, size_t at) {
    if (!is_coded) {
      std::memcpy(&plane_[at * sizeof(Vec3)], &radiance.texels[texel], rect.width * sizeof(Vec3));
      return;
    }
    for (uint32_t k = 0; k < 3 * rect.width; ++k) {
      const float value = radiance.texels[texel + k / 3][static_cast<int>(k % 3)];
      PutCode(bytes, 3 * at + k, codec.Encode(value), plane_);
    }
  });
}

absl::Status TileDecoder::Decode(const v1::Tile& tile, ShadowTexels& texels) {
  const TileGrid grid = GridOf(texels);
  if (tile.column() >= grid.columns() || tile.row() >= grid.rows()) {
    return Invalid("RANGE", "tile",
                   "found column " + std::to_string(tile.column()) + " and row " +
                       std::to_string(tile.row()) + ", need a tile of a grid of " +
                       std::to_string(grid.columns()) + " by " + std::to_string(grid.rows()));
  }
  const Rect rect = RectOf(grid, tile.column(), tile.row());
  if (auto status = DecodeCounts(tile, rect, texels); !status.ok()) return status;
  if (!texels.radiance) return absl::OkStatus();
  return DecodeRadiance(tile, rect, *texels.radiance);
}

absl::Status TileDecoder::DecodeRadiance(const v1::Tile& tile, const TileRect& rect,
                                         RadianceTexture& radiance) {
  const size_t bytes = BytesPerChannel(radiance.format);
  const auto plane = unpacker_.Unpack(tile.radiance_codec(), tile.radiance(),
                                      rect.texels() * 3 * bytes, "tile.radiance");
  if (!plane.ok()) return plane.status();
  const bool is_coded = radiance.format != RadianceFormat::kFloat32;
  const RadianceCodec codec(radiance.format, radiance.scale);
  ForRowsOfRadiance(radiance.width, rect, [&](size_t texel, size_t at) {
    if (!is_coded) {
      std::memcpy(&radiance.texels[texel], &(*plane)[at * sizeof(Vec3)], rect.width * sizeof(Vec3));
      return;
    }
    for (uint32_t k = 0; k < 3 * rect.width; ++k) {
      const uint16_t code = CodeAt(bytes, 3 * at + k, *plane);
      radiance.texels[texel + k / 3][static_cast<int>(k % 3)] = codec.Decode(code);
    }
  });
  return absl::OkStatus();
}

absl::Status TileDecoder::DecodeCounts(const v1::Tile& tile, const TileRect& rect,
                                       ShadowTexels& texels) {
  const bool all_visible = tile.counts_codec() == v1::CODEC_ALL_VISIBLE;
  if (all_visible || tile.counts_codec() == v1::CODEC_NONE_VISIBLE) {
    FillCounts(all_visible ? texels.visibility.sample_count : 0, rect, texels.visibility);
    return absl::OkStatus();
  }
  const size_t bytes_per_count = BytesPerCount(texels);
  const auto plane = unpacker_.Unpack(tile.counts_codec(), tile.counts(),
                                      rect.texels() * bytes_per_count, "tile.counts");
  if (!plane.ok()) return plane.status();
  if (ScatterCounts(*plane, rect, bytes_per_count, texels.visibility)) return absl::OkStatus();
  return Invalid("RANGE", "tile.counts", "found a count above the number of samples, need less");
}

}  // namespace penumbra
