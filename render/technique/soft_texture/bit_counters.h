// Counting how many of a series of bitmaps have each bit set, a vector of texels at a time.
//
//   BitmapCounter counter(width, rows, samples);
//   for each sample: Draw(counter.next()), counter.CountNext();
//   counter.Finish(), counter.SubtractFrom(counts, width, 0, rows);
//
// Counters are bit-sliced: plane p holds bit p of each texel's count. Four bitmaps are added at
// once, by full adders that leave carries for later, as in Harley and Seal's counting of ones.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "render/technique/soft_texture/shadow_bitmap.h"

namespace penumbra {

class BitmapCounter {
 public:
  // Counts up to `most` bitmaps of `rows` rows of `width` texels.
  BitmapCounter(uint32_t width, uint32_t rows, uint32_t most);

  // All zeros: to be drawn into.
  ShadowBitmap& next() { return batch_[in_batch_]; }
  // Counts what has been drawn.
  void CountNext();
  // To be called after the last.
  void Finish();

  // Rows that any bit was set in; none if rows_begin() ≥ rows_end().
  uint32_t rows_begin() const { return rows_begin_; }
  uint32_t rows_end() const { return rows_end_; }

  // Adds what `other`, of the same shape, has counted in rows [begin, end). Several threads may
  // each merge a part of the rows, if all but the last are multiples of kRowStep rows, between a
  // call of Touch for all of them and one of Clear.
  void Merge(const BitmapCounter& other, uint32_t begin, uint32_t end);
  void Touch(uint32_t rows_begin, uint32_t rows_end) {
    rows_begin_ = std::min(rows_begin_, rows_begin);
    rows_end_ = std::max(rows_end_, rows_end);
  }
  static constexpr uint32_t kRowStep = ShadowBitmap::kRowPadding;

  // Takes the counts of rows [begin, end) off `counts`, `width` numbers a row, the first of which
  // is row 0's.
  void SubtractFrom(uint16_t* counts, uint32_t width, uint32_t begin, uint32_t end) const;

  // Begins anew, whatever has been drawn and counted.
  void Clear();

  static constexpr size_t kBatch = 4;  // bitmaps that are added at once

 private:
  std::array<ShadowBitmap, kBatch> batch_;
  size_t in_batch_ = 0;
  std::vector<std::vector<uint32_t>> planes_;  // in the bitmaps' layout
  uint32_t rows_begin_ = std::numeric_limits<uint32_t>::max(), rows_end_ = 0;
};

// Rows of a texture that are drawn at a time: a bitmap of them should stay in a core's second-level
// cache together with its counters.
constexpr uint32_t BandRows(uint32_t width, uint32_t height) {
  constexpr uint32_t kBandWords = 1u << 13;
  return std::clamp(kBandWords / ((width + 31) / 32), 1u, height);
}

// A counter for each thread, all of one shape, so that they can be merged. Kept where textures of
// one size are counted again and again.
class BitmapCounters {
 public:
  // Makes room for `threads` counters that hold at least this.
  void Prepare(size_t threads, uint32_t width, uint32_t rows, uint32_t most);
  // A thread's own, for it to count with.
  BitmapCounter& Of(size_t thread);
  // Forgets all, in whatever state it is.
  void Drop() { counters_.clear(); }

  // That `threads` of them take.
  static size_t Bytes(size_t threads, uint32_t width, uint32_t rows, uint32_t most);

 private:
  uint32_t width_ = 0, rows_ = 0, most_ = 0;
  std::vector<std::unique_ptr<BitmapCounter>> counters_;  // null: not asked for yet
};

}  // namespace penumbra
