#include "render/technique/soft_texture/gl/pages.h"

#include "gtest/gtest.h"
#include "tests/support/random_scene.h"

namespace penumbra::texture_gl {
namespace {

// Every texel of every receiver in one place, and no place with two.
void ExpectCovered(const std::vector<TexelSize>& sizes) {
  std::vector<std::vector<int>> rows(sizes.size());
  for (size_t r = 0; r < sizes.size(); ++r) rows[r].resize(sizes[r].height);
  for (const Page& page : LayOutPages(sizes)) {
    EXPECT_TRUE(size_t{page.width} * page.height <= kPageTexels || page.height == 1);
    std::vector<bool> taken(size_t{page.width} * page.height);
    for (const Tile& tile : page.tiles) {
      const uint32_t width = sizes[tile.receiver].width;
      ASSERT_LE(tile.x + width, page.width);
      ASSERT_LE(tile.y + tile.rows, page.height);
      for (uint32_t row = 0; row < tile.rows; ++row) {
        ++rows[tile.receiver][tile.first_row + row];
        for (uint32_t x = tile.x; x < tile.x + width; ++x) {
          auto texel = taken[size_t{tile.y + row} * page.width + x];
          ASSERT_FALSE(texel);
          texel = true;
        }
      }
    }
  }
  for (const auto& counts : rows) {
    for (const int count : counts) ASSERT_EQ(count, 1);
  }
}

TEST(PagesTest, HoldEveryRowOnce) {
  ExpectCovered({{1, 1}});
  ExpectCovered({{16384, 200}, {1, 16384}, {1024, 1024}, {1025, 3}});
  penumbra::testing::Dice dice(1);
  std::vector<TexelSize> sizes;
  for (int i = 0; i < 60; ++i) sizes.push_back({1 + dice.Below(700), 1 + dice.Below(700)});
  ExpectCovered(sizes);
}

TEST(PagesTest, SmallReceiversShareOne) {
  const std::vector<TexelSize> sizes(32, {128, 128});
  EXPECT_EQ(LayOutPages(sizes).size(), 1u);
  EXPECT_TRUE(LayOutPages({}).empty());
}

}  // namespace
}  // namespace penumbra::texture_gl
