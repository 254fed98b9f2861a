// Pictures are drawn in square tiles, so that the size of a picture does not decide how much GPU
// memory it takes.
#pragma once

#include <span>

#include "client/display/picture.h"
#include "render/math/aabb.h"
#include "render/math/vec.h"

namespace penumbra {

// A rectangle of pixels at the upper left of a square of `side` pixels that is drawn; y from the
// top.
struct PictureTile {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
  int side = 0;
};

// Takes the clip space of the whole picture to that of the tile's square.
DMat4 TileFromClip(const PictureTile& tile, int picture_width, int picture_height);

// Whether all of `box` lies outside one side of the view.
bool IsOutside(const DMat4& clip_from_world, const Aabb& box);

// Averages `samples`, n × n a pixel of the square and the bottom row first, into the tile's pixels.
void ResolveTile(std::span<const Vec4> samples, int n, const PictureTile& tile, Picture& picture);

}  // namespace penumbra
