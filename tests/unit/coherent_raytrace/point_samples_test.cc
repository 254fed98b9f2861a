// Where samples are: anywhere in their cells, whichever are placed together.
#include "render/technique/coherent_raytrace/point_samples.h"

#include <gtest/gtest.h>

namespace penumbra {
namespace {

// Even in each cell, and between neighbours without relation.
TEST(SampleBatchTest, FillTheirCellsAndAreDecorrelated) {
  double sum = 0, sum2 = 0, product = 0;
  constexpr int kPoints = 2000;
  for (int i = 0; i < kPoints; ++i) {
    SampleBatch samples, next;
    samples.Add(CellMask::All(4), {4, 3}, SampleSeed(9, i));
    next.Add(CellMask::All(4), {4, 3}, SampleSeed(9, i + 1));
    for (uint32_t y = 0; y < 4; ++y) {
      for (uint32_t x = 0; x < 4; ++x) {
        const uint32_t k = 4 * y + x;  // one block
        ASSERT_EQ(samples.cell[k], 32 * y + x);
        const double u = 4 * samples.u[k] - x, v = 4 * samples.v[k] - y;
        ASSERT_TRUE(u >= 0 && u < 1 && v >= 0 && v < 1);
        EXPECT_EQ(samples.part[k], uint32_t(3 * (y + v)) * 12 + uint32_t(3 * (x + u)));
        sum += u + v, sum2 += u * u + v * v;
        product += (u - 0.5) * (v - 0.5) + (u - 0.5) * (4 * next.u[k] - x - 0.5) +
                   (u - 0.5) * (4 * samples.u[4 * y + (x + 1) % 4] - (x + 1) % 4 - 0.5);
      }
    }
  }
  const double n = 16.0 * kPoints;
  EXPECT_NEAR(sum / (2 * n), 0.5, 0.005);
  EXPECT_NEAR(sum2 / (2 * n), 1.0 / 3, 0.005);
  EXPECT_NEAR(product / n, 0.0, 0.005);
}

// A sample is where it is, whichever are placed with it.
TEST(SampleBatchTest, SamplesDoNotDependOnEachOther) {
  SampleBatch all, some;
  all.Add(CellMask::All(16), {16, 3}, SampleSeed(1, 5));
  some.Add(CellMask::All(16), {16, 3}, SampleSeed(1, 4));
  const size_t first = some.count;
  some.Add(CellMask::Exterior(16), {16, 3}, SampleSeed(1, 5));
  ASSERT_EQ(some.count, first + 60);
  for (size_t i = first; i < some.count; ++i) {
    size_t k = 0;
    while (all.cell[k] != some.cell[i]) ++k;
    EXPECT_EQ(all.u[k], some.u[i]);
    EXPECT_EQ(all.v[k], some.v[i]);
    EXPECT_EQ(all.part[k], some.part[i]);
  }
}

}  // namespace
}  // namespace penumbra
