#include "client/display/picture_tile.h"

namespace penumbra {

DMat4 TileFromClip(const PictureTile& tile, int picture_width, int picture_height) {
  const double x_scale = static_cast<double>(picture_width) / tile.side;
  const double y_scale = static_cast<double>(picture_height) / tile.side;
  // The tile's left and top edges go to −1 and 1.
  const double left = 2.0 * tile.x / picture_width - 1.0;
  const double top = 1.0 - 2.0 * tile.y / picture_height;
  DMat4 m(1.0);
  m[0][0] = x_scale;
  m[1][1] = y_scale;
  m[3][0] = -1.0 - x_scale * left;
  m[3][1] = 1.0 - y_scale * top;
  return m;
}

bool IsOutside(const DMat4& clip_from_world, const Aabb& box) {
  bool left = true, right = true, below = true, above = true, behind = true;
  for (int corner = 0; corner < 8; ++corner) {
    const DVec4 p = clip_from_world * DVec4((corner & 1) ? box.max.x : box.min.x,
                                            (corner & 2) ? box.max.y : box.min.y,
                                            (corner & 4) ? box.max.z : box.min.z, 1.0);
    left &= p.x < -p.w;
    right &= p.x > p.w;
    below &= p.y < -p.w;
    above &= p.y > p.w;
    behind &= p.w <= 0;
  }
  return left || right || below || above || behind;
}

void ResolveTile(std::span<const Vec4> samples, int n, const PictureTile& tile, Picture& picture) {
  const int row_length = tile.side * n;
  for (int y = 0; y < tile.height; ++y) {
    for (int x = 0; x < tile.width; ++x) {
      Vec4 sum(0);
      for (int j = 0; j < n; ++j) {
        const int row = row_length - 1 - (y * n + j);
        const Vec4* first = &samples[static_cast<size_t>(row) * row_length + x * n];
        for (int i = 0; i < n; ++i) sum += first[i];
      }
      picture.pixels[static_cast<size_t>(tile.y + y) * picture.width + tile.x + x] =
          sum / static_cast<float>(n * n);
    }
  }
}

}  // namespace penumbra
