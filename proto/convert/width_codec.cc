#include "proto/convert/width_codec.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

#include "proto/convert/float_plane.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

uint32_t TilesAlong(uint32_t texels) { return (texels + kWidthTileSide - 1) / kWidthTileSide; }

struct Rect {
  uint32_t x, y, width, height;

  size_t texels() const { return size_t{width} * height; }
};

Rect RectOf(const LightView& view, uint32_t column, uint32_t row) {
  const uint32_t x = column * kWidthTileSide, y = row * kWidthTileSide;
  return {x, y, std::min(kWidthTileSide, view.width - x),
          std::min(kWidthTileSide, view.height - y)};
}

// In the order of the protocol.
template <typename Face>
auto PlanesOf(Face& face) {
  std::vector planes = {&face.near.depths, &face.near.widths};
  if (face.far) planes.insert(planes.end(), {&face.far->depths, &face.far->widths});
  return planes;
}
bool IsWidths(size_t plane) { return plane % 2 == 1; }

absl::Status Invalid(const std::string& field, const std::string& text) {
  return FieldError(absl::StatusCode::kInvalidArgument, "RANGE", field, text);
}

// Infinity is a number here.
bool AreInRange(std::span<const float> floats, bool are_widths, bool any_sign) {
  return std::ranges::all_of(floats, [&](float x) {
    if (are_widths) return x >= 0;
    return any_sign ? !std::isnan(x) && x > -kNoDepth : x > 0;
  });
}

}  // namespace

std::vector<WidthTilePlace> WidthTilesOf(const ShadowWidthMap& map) {
  std::vector<WidthTilePlace> places;
  for (uint32_t face = 0; face < map.faces.size(); ++face) {
    const LightView& view = map.faces[face].view;
    for (uint32_t row = 0; row < TilesAlong(view.height); ++row) {
      for (uint32_t column = 0; column < TilesAlong(view.width); ++column) {
        places.push_back({face, column, row});
      }
    }
  }
  return places;
}

bool HaveSameFaces(const ShadowWidthMap& a, const ShadowWidthMap& b) {
  return std::ranges::equal(
      a.faces, b.faces, [](const ShadowWidthFace& one, const ShadowWidthFace& other) {
        return IsSameView(one.view, other.view) && one.window.min == other.window.min &&
               one.window.max == other.window.max && one.far.has_value() == other.far.has_value();
      });
}

bool WidthTilesEqual(const ShadowWidthMap& a, const ShadowWidthMap& b,
                     const WidthTilePlace& place) {
  const ShadowWidthFace &one = a.faces[place.face], &other = b.faces[place.face];
  const Rect rect = RectOf(one.view, place.column, place.row);
  const auto in_one = PlanesOf(one), in_other = PlanesOf(other);
  for (size_t p = 0; p < in_one.size(); ++p) {
    for (uint32_t j = 0; j < rect.height; ++j) {
      const size_t first = size_t{rect.y + j} * one.view.width + rect.x;
      const size_t bytes = rect.width * sizeof(float);
      if (std::memcmp(&(*in_one[p])[first], &(*in_other[p])[first], bytes) != 0) return false;
    }
  }
  return true;
}

v1::WidthTile WidthTileEncoder::Encode(const ShadowWidthMap& map, const WidthTilePlace& place) {
  const ShadowWidthFace& face = map.faces[place.face];
  const Rect rect = RectOf(face.view, place.column, place.row);
  v1::WidthTile tile;
  tile.set_face(place.face);
  tile.set_column(place.column);
  tile.set_row(place.row);
  for (const std::vector<float>* plane : PlanesOf(face)) {
    floats_.clear();
    for (uint32_t j = 0; j < rect.height; ++j) {
      const float* const row = plane->data() + size_t{rect.y + j} * face.view.width + rect.x;
      floats_.insert(floats_.end(), row, row + rect.width);
    }
    ToPlane(floats_, plane_);
    v1::FloatPlane& added = *tile.add_planes();
    added.set_codec(packer_.Pack(plane_, *added.mutable_packed()));
  }
  return tile;
}

WidthTiles::WidthTiles(ShadowWidthMap& map, const ShadowWidthMap* before) {
  const bool is_same = before != nullptr && HaveSameFaces(map, *before);
  for (size_t f = 0; f < map.faces.size(); ++f) {
    ShadowWidthFace& face = map.faces[f];
    if (is_same) {
      face = before->faces[f];
    } else {
      for (std::vector<float>* plane : PlanesOf(face)) {
        plane->assign(size_t{face.view.width} * face.view.height, 0.0f);
      }
    }
    const uint32_t columns = TilesAlong(face.view.width), rows = TilesAlong(face.view.height);
    faces_.push_back({columns, rows, std::vector<bool>(size_t{columns} * rows, is_same)});
  }
}

absl::Status WidthTiles::Add(const v1::WidthTile& proto, ShadowWidthMap& map) {
  const bool is_there = proto.face() < faces_.size() &&
                        proto.column() < faces_[proto.face()].columns &&
                        proto.row() < faces_[proto.face()].rows;
  if (!is_there) {
    return Invalid("width_tile", "found face " + std::to_string(proto.face()) + ", column " +
                                     std::to_string(proto.column()) + " and row " +
                                     std::to_string(proto.row()) + ", need a tile of the map");
  }
  ShadowWidthFace& face = map.faces[proto.face()];
  const auto planes = PlanesOf(face);
  if (static_cast<size_t>(proto.planes_size()) != planes.size()) {
    return Invalid("width_tile.planes", "found " + std::to_string(proto.planes_size()) + ", need " +
                                            std::to_string(planes.size()));
  }
  const Rect rect = RectOf(face.view, proto.column(), proto.row());
  PlaneUnpacker unpacker;
  std::vector<float> floats;
  for (size_t p = 0; p < planes.size(); ++p) {
    const std::string field = "width_tile.planes[" + std::to_string(p) + "]";
    const v1::FloatPlane& packed = proto.planes(static_cast<int>(p));
    const auto plane = unpacker.Unpack(packed.codec(), packed.packed(),
                                       rect.texels() * sizeof(float), field.c_str());
    if (!plane.ok()) return plane.status();
    FromPlane(*plane, floats);
    if (!AreInRange(floats, IsWidths(p), face.view.from_infinity)) {
      return Invalid(field, IsWidths(p) ? "found one that is no width, need numbers >= 0"
                                        : "found one that is no depth, need numbers");
    }
    for (uint32_t j = 0; j < rect.height; ++j) {
      std::copy_n(floats.data() + size_t{j} * rect.width, rect.width,
                  planes[p]->data() + size_t{rect.y + j} * face.view.width + rect.x);
    }
  }
  Face& mine = faces_[proto.face()];
  mine.has_tile[size_t{proto.row()} * mine.columns + proto.column()] = true;
  return absl::OkStatus();
}

size_t WidthTiles::missing_count() const {
  size_t missing = 0;
  for (const Face& face : faces_) missing += std::ranges::count(face.has_tile, false);
  return missing;
}

}  // namespace penumbra
