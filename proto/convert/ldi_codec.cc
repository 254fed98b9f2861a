#include "proto/convert/ldi_codec.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <numeric>
#include <span>
#include <string>
#include <utility>

#include "proto/convert/float_plane.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

static_assert(std::endian::native == std::endian::little, "planes are copied as they lie");

uint32_t TilesAlong(uint32_t pixels) { return (pixels + kLdiTileSide - 1) / kLdiTileSide; }

struct Rect {
  uint32_t x, y, width, height;

  size_t pixels() const { return size_t{width} * height; }
};

Rect RectOf(uint32_t width, uint32_t height, uint32_t column, uint32_t row) {
  const uint32_t x = column * kLdiTileSide, y = row * kLdiTileSide;
  return {x, y, std::min(kLdiTileSide, width - x), std::min(kLdiTileSide, height - y)};
}

// The layers of a row of a tile: they follow each other in the face.
struct Span {
  size_t begin, end;
};

Span RowOf(const LdiFace& face, const Rect& rect, uint32_t j) {
  const size_t first = size_t{rect.y + j} * face.view.width + rect.x;
  return {face.offsets[first], face.offsets[first + rect.width]};
}

Rect RectOf(const LdiFace& face, const LdiTilePlace& place) {
  return RectOf(face.view.width, face.view.height, place.column, place.row);
}

template <typename T>
bool Equal(const std::vector<T>& a, Span span_a, const std::vector<T>& b, Span span_b) {
  return std::equal(a.begin() + static_cast<std::ptrdiff_t>(span_a.begin),
                    a.begin() + static_cast<std::ptrdiff_t>(span_a.end),
                    b.begin() + static_cast<std::ptrdiff_t>(span_b.begin),
                    b.begin() + static_cast<std::ptrdiff_t>(span_b.end));
}

size_t BytesPerCount(uint32_t sample_count) { return sample_count <= 255 ? 1 : 2; }

absl::Status Invalid(const char* reason, const char* field, const std::string& text) {
  return FieldError(absl::StatusCode::kInvalidArgument, reason, field, text);
}

// Each pixel's nearest first, none twice.
bool AreInOrder(std::span<const uint8_t> layers, std::span<const float> depths, bool any_sign) {
  size_t i = 0;
  for (const uint8_t count : layers) {
    for (size_t k = 0; k < count; ++k, ++i) {
      if (!std::isfinite(depths[i]) || (!any_sign && !(depths[i] > 0))) return false;
      if (k > 0 && !(depths[i] > depths[i - 1])) return false;
    }
  }
  return true;
}

}  // namespace

std::vector<LdiTilePlace> LdiTilesOf(const AttenuationLdi& ldi) {
  std::vector<LdiTilePlace> places;
  for (uint32_t face = 0; face < ldi.faces.size(); ++face) {
    const LightView& view = ldi.faces[face].view;
    for (uint32_t row = 0; row < TilesAlong(view.height); ++row) {
      for (uint32_t column = 0; column < TilesAlong(view.width); ++column) {
        places.push_back({face, column, row});
      }
    }
  }
  return places;
}

bool HaveSameFaces(const AttenuationLdi& a, const AttenuationLdi& b) {
  return std::ranges::equal(a.faces, b.faces, [](const LdiFace& one, const LdiFace& other) {
    return IsSameView(one.view, other.view);
  });
}

bool LdiTilesEqual(const AttenuationLdi& a, const AttenuationLdi& b, const LdiTilePlace& place) {
  if (BytesPerCount(a.sample_count) != BytesPerCount(b.sample_count)) return false;
  const LdiFace &one = a.faces[place.face], &other = b.faces[place.face];
  const Rect rect = RectOf(one, place);
  for (uint32_t j = 0; j < rect.height; ++j) {
    const size_t first = size_t{rect.y + j} * one.view.width + rect.x;
    for (uint32_t i = 0; i < rect.width; ++i) {
      const size_t p = first + i;
      if (one.offsets[p + 1] - one.offsets[p] != other.offsets[p + 1] - other.offsets[p]) {
        return false;
      }
    }
    const Span in_one = RowOf(one, rect, j), in_other = RowOf(other, rect, j);
    if (!Equal(one.counts, in_one, other.counts, in_other) ||
        !Equal(one.depths, in_one, other.depths, in_other)) {
      return false;
    }
  }
  return true;
}

v1::LdiTile LdiTileEncoder::Encode(const AttenuationLdi& ldi, const LdiTilePlace& place) {
  const LdiFace& face = ldi.faces[place.face];
  const Rect rect = RectOf(face, place);
  v1::LdiTile tile;
  tile.set_face(place.face);
  tile.set_column(place.column);
  tile.set_row(place.row);
  std::vector<float> depths;
  std::vector<uint16_t> counts;
  plane_.clear();
  for (uint32_t j = 0; j < rect.height; ++j) {
    const size_t first = size_t{rect.y + j} * face.view.width + rect.x;
    for (uint32_t i = 0; i < rect.width; ++i) {
      plane_.push_back(static_cast<char>(face.offsets[first + i + 1] - face.offsets[first + i]));
    }
    const Span row = RowOf(face, rect, j);
    depths.insert(depths.end(), face.depths.data() + row.begin, face.depths.data() + row.end);
    counts.insert(counts.end(), face.counts.data() + row.begin, face.counts.data() + row.end);
  }
  tile.set_layers_codec(packer_.Pack(plane_, *tile.mutable_layers()));
  ToPlane(depths, plane_);
  tile.set_depths_codec(packer_.Pack(plane_, *tile.mutable_depths()));
  const size_t bytes = BytesPerCount(ldi.sample_count);
  plane_.resize(counts.size() * bytes);
  for (size_t i = 0; i < counts.size(); ++i) std::memcpy(&plane_[i * bytes], &counts[i], bytes);
  tile.set_counts_codec(packer_.Pack(plane_, *tile.mutable_counts()));
  return tile;
}

LdiTiles::LdiTiles(const AttenuationLdi& ldi) : sample_count_(ldi.sample_count) {
  for (const LdiFace& face : ldi.faces) {
    const uint32_t width = face.view.width, height = face.view.height;
    Face& mine =
        faces_.emplace_back(Face{width, height, TilesAlong(width), face.view.from_infinity, {}});
    mine.tiles.resize(size_t{mine.columns} * TilesAlong(height));
  }
}

LdiTiles::LdiTiles(const AttenuationLdi& ldi, const LdiTiles& before) : LdiTiles(before) {
  sample_count_ = ldi.sample_count;
  if (sample_count_ >= before.sample_count_) return;
  for (Face& face : faces_) {
    for (auto& tile : face.tiles) {
      const auto is_above = [this](uint16_t count) { return count > sample_count_; };
      if (!tile || std::ranges::none_of(tile->counts, is_above)) continue;
      layers_ -= tile->depths.size();
      tile = nullptr;
    }
  }
}

absl::Status LdiTiles::Add(const v1::LdiTile& proto) {
  const bool has_face = proto.face() < faces_.size();
  if (!has_face || proto.column() >= faces_[proto.face()].columns ||
      proto.row() >= TilesAlong(faces_[proto.face()].height)) {
    return Invalid("RANGE", "ldi_tile",
                   "found face " + std::to_string(proto.face()) + ", column " +
                       std::to_string(proto.column()) + " and row " + std::to_string(proto.row()) +
                       ", need a tile of the map");
  }
  Face& face = faces_[proto.face()];
  auto tile = std::make_shared<Tile>();
  tile->layers.resize(RectOf(face.width, face.height, proto.column(), proto.row()).pixels());
  if (auto status = Read(proto, face.from_infinity, *tile); !status.ok()) return status;
  auto& place = face.tiles[size_t{proto.row()} * face.columns + proto.column()];
  const uint64_t layers = layers_ + tile->depths.size() - (place ? place->depths.size() : 0);
  if (layers > kMaxMapLayers) {
    return Invalid("RANGE", "ldi_tile.layers",
                   "found " + std::to_string(layers) + " of all tiles so far, need at most " +
                       std::to_string(kMaxMapLayers));
  }
  layers_ = layers;
  place = std::move(tile);
  return absl::OkStatus();
}

absl::Status LdiTiles::Read(const v1::LdiTile& proto, bool from_infinity, Tile& tile) {
  PlaneUnpacker unpacker;
  const auto layers =
      unpacker.Unpack(proto.layers_codec(), proto.layers(), tile.layers.size(), "ldi_tile.layers");
  if (!layers.ok()) return layers.status();
  std::memcpy(tile.layers.data(), layers->data(), layers->size());
  if (*std::ranges::max_element(tile.layers) > kMaxTileLayers) {
    return Invalid("RANGE", "ldi_tile.layers", "found more than 128 of a pixel, need fewer");
  }
  const size_t count = std::accumulate(tile.layers.begin(), tile.layers.end(), size_t{0});
  const auto depths =
      unpacker.Unpack(proto.depths_codec(), proto.depths(), count * 4, "ldi_tile.depths");
  if (!depths.ok()) return depths.status();
  FromPlane(*depths, tile.depths);
  if (!AreInOrder(tile.layers, tile.depths, from_infinity)) {
    return Invalid("RANGE", "ldi_tile.depths",
                   "found some that are no depths, or not each pixel's nearest first");
  }
  const size_t bytes = BytesPerCount(sample_count_);
  const auto counts =
      unpacker.Unpack(proto.counts_codec(), proto.counts(), count * bytes, "ldi_tile.counts");
  if (!counts.ok()) return counts.status();
  tile.counts.resize(count);
  for (size_t i = 0; i < count; ++i) {
    std::memcpy(&tile.counts[i], &(*counts)[i * bytes], bytes);
    if (tile.counts[i] <= sample_count_) continue;
    return Invalid("RANGE", "ldi_tile.counts", "found one above the number of samples, need less");
  }
  return absl::OkStatus();
}

size_t LdiTiles::missing_count() const {
  size_t missing = 0;
  for (const Face& face : faces_) missing += std::ranges::count(face.tiles, nullptr);
  return missing;
}

void LdiTiles::Finish(AttenuationLdi& ldi) const {
  for (size_t f = 0; f < faces_.size(); ++f) {
    const Face& face = faces_[f];
    LdiFace& out = ldi.faces[f];
    out.offsets = {0};
    out.offsets.reserve(size_t{face.width} * face.height + 1);
    out.depths.clear();
    out.counts.clear();
    // Where in each tile of a row of tiles its next pixel's layers begin.
    std::vector<size_t> next(face.columns);
    for (uint32_t y = 0; y < face.height; ++y) {
      if (y % kLdiTileSide == 0) std::ranges::fill(next, size_t{0});
      for (uint32_t column = 0; column < face.columns; ++column) {
        const Tile& tile = *face.tiles[size_t{y / kLdiTileSide} * face.columns + column];
        const Rect rect = RectOf(face.width, face.height, column, y / kLdiTileSide);
        const uint8_t* const layers = &tile.layers[size_t{y - rect.y} * rect.width];
        for (uint32_t i = 0; i < rect.width; ++i) {
          out.offsets.push_back(out.offsets.back() + layers[i]);
        }
        const size_t count = out.offsets.back() - out.depths.size(), from = next[column];
        out.depths.insert(out.depths.end(), tile.depths.data() + from,
                          tile.depths.data() + from + count);
        out.counts.insert(out.counts.end(), tile.counts.data() + from,
                          tile.counts.data() + from + count);
        next[column] += count;
      }
    }
  }
}

}  // namespace penumbra
