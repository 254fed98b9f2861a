#include "render/technique/soft_texture/gl/pages.h"

#include <algorithm>
#include <numeric>

namespace penumbra::texture_gl {
namespace {

// Pages on which several receivers stand are no wider than this: 2¹⁰ × 2¹⁰ texels.
constexpr uint32_t kSharedWidth = 1024;

// Puts receivers into rows of a page, tallest first.
// Source  Coffman, Garey, Johnson and Tarjan 1980, next-fit decreasing height
class Shelves {
 public:
  void Add(size_t receiver, TexelSize size) {
    if (x_ + size.width > kSharedWidth) {
      y_ += shelf_height_;
      x_ = shelf_height_ = 0;
    }
    if (y_ + size.height > kPageTexels / kSharedWidth) Close();
    page_.tiles.push_back(
        {.receiver = receiver, .first_row = 0, .rows = size.height, .x = x_, .y = y_});
    x_ += size.width;
    shelf_height_ = std::max(shelf_height_, size.height);
    page_.width = std::max(page_.width, x_);
    page_.height = std::max(page_.height, y_ + size.height);
  }
  void Close() {
    if (!page_.tiles.empty()) pages_.push_back(std::move(page_));
    page_ = {};
    x_ = y_ = shelf_height_ = 0;
  }
  std::vector<Page> Take() { return std::move(pages_); }

 private:
  Page page_;
  uint32_t x_ = 0, y_ = 0, shelf_height_ = 0;
  std::vector<Page> pages_;
};

}  // namespace

std::vector<Page> LayOutPages(std::span<const TexelSize> sizes) {
  std::vector<size_t> order(sizes.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return sizes[a].height > sizes[b].height; });
  Shelves shelves;
  std::vector<Page> bands;
  for (const size_t receiver : order) {
    const TexelSize size = sizes[receiver];
    if (size.width <= kSharedWidth && size.height <= kPageTexels / kSharedWidth) {
      shelves.Add(receiver, size);
      continue;
    }
    const uint32_t most_rows = std::max(1u, kPageTexels / size.width);
    for (uint32_t row = 0; row < size.height; row += most_rows) {
      const uint32_t rows = std::min(most_rows, size.height - row);
      bands.push_back({size.width, rows, {{receiver, row, rows, 0, 0}}});
    }
  }
  shelves.Close();
  std::vector<Page> pages = shelves.Take();
  pages.insert(pages.end(), bands.begin(), bands.end());
  return pages;
}

}  // namespace penumbra::texture_gl
