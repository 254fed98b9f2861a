#include "render/technique/soft_texture/bit_counters.h"

#include <algorithm>
#include <bit>
#include <span>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/technique/soft_texture/bit_counters.cc"
#include "hwy/foreach_target.h"  // compiles this file once for each target
#include "hwy/highway.h"
#include "render/technique/soft_texture/coverage_kernel.h"

HWY_BEFORE_NAMESPACE();
namespace penumbra {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using U = hn::CappedTag<uint32_t, kMaxLanes>;
using VU = hn::Vec<U>;
using Planes = std::span<std::vector<uint32_t>>;

// Adds three bits of one weight: `sum` keeps its weight, what is returned has twice that.
HWY_INLINE VU FullAdd(VU& sum, VU b, VU c) {
  const VU some = hn::Xor(sum, b);
  const VU carry = hn::Or(hn::And(sum, b), hn::And(some, c));
  sum = hn::Xor(some, c);
  return carry;
}

// Adds four bitmaps to the planes, of which there are two at least, and clears them.
void AddAndClear(std::span<ShadowBitmap> batch, Planes planes) {
  const U u;
  const uint32_t rows = batch[0].stride - ShadowBitmap::kRowPadding;
  for (uint32_t column = 0; column < batch[0].columns; ++column) {
    uint32_t* words[4];
    uint32_t begin = rows, end = 0;
    for (size_t k = 0; k < 4; ++k) {
      words[k] = batch[k].Column(column);
      begin = std::min(begin, batch[k].touched_rows_begin[column]);
      end = std::max(end, batch[k].touched_rows_end[column]);
      batch[k].touched_rows_begin[column] = rows;
      batch[k].touched_rows_end[column] = 0;
    }
    const size_t offset = size_t{column} * batch[0].stride;
    for (uint32_t row = begin; row < end; row += hn::Lanes(u)) {
      VU bits[4];
      for (size_t k = 0; k < 4; ++k) {
        bits[k] = hn::LoadU(u, words[k] + row);
        hn::StoreU(hn::Zero(u), u, words[k] + row);
      }
      uint32_t* const ones_at = planes[0].data() + offset + row;
      uint32_t* const twos_at = planes[1].data() + offset + row;
      VU ones = hn::LoadU(u, ones_at), twos = hn::LoadU(u, twos_at);
      const VU first_twos = FullAdd(ones, bits[0], bits[1]);
      const VU second_twos = FullAdd(ones, bits[2], bits[3]);
      VU carry = FullAdd(twos, first_twos, second_twos);
      hn::StoreU(ones, u, ones_at);
      hn::StoreU(twos, u, twos_at);
      for (size_t p = 2; p < planes.size(); ++p) {
        if (hn::AllTrue(u, hn::Eq(carry, hn::Zero(u)))) break;
        uint32_t* const sum = planes[p].data() + offset + row;
        const VU old = hn::LoadU(u, sum);
        hn::StoreU(hn::Xor(old, carry), u, sum);
        carry = hn::And(old, carry);
      }
    }
  }
}

// Adds the numbers in `others` to those in `planes`, for rows [begin, end) of all columns.
void MergePlanes(Planes planes, std::span<const std::vector<uint32_t>> others, uint32_t stride,
                 uint32_t begin, uint32_t end) {
  const U u;
  for (size_t offset = 0; offset < planes[0].size(); offset += stride) {
    for (size_t at = offset + begin; at < offset + end; at += hn::Lanes(u)) {
      VU carry = hn::Zero(u);
      for (size_t p = 0; p < planes.size(); ++p) {
        VU sum = hn::LoadU(u, planes[p].data() + at);
        carry = FullAdd(sum, hn::LoadU(u, others[p].data() + at), carry);
        hn::StoreU(sum, u, planes[p].data() + at);
      }
    }
  }
}

#if HWY_TARGET == HWY_SCALAR

void SubtractPlanes(std::span<const std::vector<uint32_t>> planes, uint32_t stride, uint32_t begin,
                    uint32_t end, uint32_t width, uint16_t* counts) {
  for (uint32_t row = begin; row < end; ++row) {
    for (uint32_t texel = 0; texel < width; ++texel) {
      const size_t word = size_t{texel / 32} * stride + row;
      uint32_t count = 0;
      for (size_t p = 0; p < planes.size(); ++p) count += (planes[p][word] >> texel % 32 & 1) << p;
      uint16_t& left = counts[size_t{row} * width + texel];
      left = static_cast<uint16_t>(left - count);
    }
  }
}

#else

using U8 = hn::Full128<uint8_t>;
using U16 = hn::Full128<uint16_t>;
using U32 = hn::Full128<uint32_t>;
using U64 = hn::Full128<uint64_t>;

// Two 8×8 bit matrices turned over their diagonals: bit k of byte p becomes bit p of byte k.
// (Warren, Hacker's Delight, §7-3)
HWY_INLINE hn::Vec<U64> TransposeBits(hn::Vec<U64> x) {
  const U64 u64;
  auto t = hn::And(hn::Xor(x, hn::ShiftRight<7>(x)), hn::Set(u64, 0x00AA00AA00AA00AA));
  x = hn::Xor(hn::Xor(x, t), hn::ShiftLeft<7>(t));
  t = hn::And(hn::Xor(x, hn::ShiftRight<14>(x)), hn::Set(u64, 0x0000CCCC0000CCCC));
  x = hn::Xor(hn::Xor(x, t), hn::ShiftLeft<14>(t));
  t = hn::And(hn::Xor(x, hn::ShiftRight<28>(x)), hn::Set(u64, 0x00000000F0F0F0F0));
  return hn::Xor(hn::Xor(x, t), hn::ShiftLeft<28>(t));
}

// Of the words of eight planes for 32 texels, those of planes 0 to 3 and of 4 to 7: the numbers of
// texels 0 to 15 and of 16 to 31, a byte each.
HWY_INLINE void BytesOf(hn::Vec<U32> low_planes, hn::Vec<U32> high_planes,
                        hn::Vec<U8> (&texels)[2]) {
  const U8 u8;
  const U32 u32;
  const U64 u64;
  // The same byte of all four words together.
  HWY_ALIGN static constexpr uint8_t kByPlace[16] = {0, 4, 8,  12, 1, 5, 9,  13,
                                                     2, 6, 10, 14, 3, 7, 11, 15};
  const auto by_place = hn::Load(u8, kByPlace);
  const auto low = hn::BitCast(u32, hn::TableLookupBytes(hn::BitCast(u8, low_planes), by_place));
  const auto high = hn::BitCast(u32, hn::TableLookupBytes(hn::BitCast(u8, high_planes), by_place));
  texels[0] = hn::BitCast(u8, TransposeBits(hn::BitCast(u64, hn::InterleaveLower(u32, low, high))));
  texels[1] = hn::BitCast(u8, TransposeBits(hn::BitCast(u64, hn::InterleaveUpper(u32, low, high))));
}

// Four rows' words of four planes, `rows[p]` plane p's, become row by row.
HWY_INLINE void TransposeWords(hn::Vec<U32> (&rows)[4]) {
  const U32 u32;
  const U64 u64;
  const auto as64 = [&](auto v) HWY_ATTR { return hn::BitCast(u64, v); };
  const auto a = as64(hn::InterleaveLower(u32, rows[0], rows[1]));
  const auto b = as64(hn::InterleaveLower(u32, rows[2], rows[3]));
  const auto c = as64(hn::InterleaveUpper(u32, rows[0], rows[1]));
  const auto d = as64(hn::InterleaveUpper(u32, rows[2], rows[3]));
  rows[0] = hn::BitCast(u32, hn::InterleaveLower(u64, a, b));
  rows[1] = hn::BitCast(u32, hn::InterleaveUpper(u64, a, b));
  rows[2] = hn::BitCast(u32, hn::InterleaveLower(u64, c, d));
  rows[3] = hn::BitCast(u32, hn::InterleaveUpper(u64, c, d));
}

void SubtractPlanes(std::span<const std::vector<uint32_t>> planes, uint32_t stride, uint32_t begin,
                    uint32_t end, uint32_t width, uint16_t* counts) {
  const U8 u8;
  const U16 u16;
  const U32 u32;
  constexpr size_t kMostGroups = 4;  // of four planes
  const size_t groups = planes.size() <= 8 ? 2 : kMostGroups;
  for (uint32_t column = 0; 32 * column < width; ++column) {
    const uint32_t texels = std::min(width - 32 * column, 32u);
    for (uint32_t row = begin; row < end; row += 4) {
      const size_t word = size_t{column} * stride + row;
      hn::Vec<U32> rows[kMostGroups][4];
      auto any = hn::Zero(u32);
      for (size_t p = 0; p < 4 * groups; ++p) {
        rows[p / 4][p % 4] =
            p < planes.size() ? hn::LoadU(u32, planes[p].data() + word) : hn::Zero(u32);
        any = hn::Or(any, rows[p / 4][p % 4]);
      }
      if (hn::AllTrue(u32, hn::Eq(any, hn::Zero(u32)))) continue;
      for (size_t g = 0; g < groups; ++g) TransposeWords(rows[g]);
      for (uint32_t r = 0; r < std::min(4u, end - row); ++r) {
        hn::Vec<U8> low[2], high[2] = {hn::Zero(u8), hn::Zero(u8)};
        BytesOf(rows[0][r], rows[1][r], low);
        if (groups > 2) BytesOf(rows[2][r], rows[3][r], high);
        uint16_t* const row_counts = counts + size_t{row + r} * width + 32 * column;
        uint16_t part[32] = {};  // where there is no room for whole vectors
        uint16_t* const left = texels == 32 ? row_counts : part;
        if (texels < 32) std::copy_n(row_counts, texels, part);
        for (size_t k = 0; k < 2; ++k) {
          const auto lower = hn::BitCast(u16, hn::InterleaveLower(u8, low[k], high[k]));
          const auto upper = hn::BitCast(u16, hn::InterleaveUpper(u8, low[k], high[k]));
          uint16_t* const at = left + 16 * k;
          hn::StoreU(hn::Sub(hn::LoadU(u16, at), lower), u16, at);
          hn::StoreU(hn::Sub(hn::LoadU(u16, at + 8), upper), u16, at + 8);
        }
        if (texels < 32) std::copy_n(part, texels, row_counts);
      }
    }
  }
}

#endif  // HWY_SCALAR

}  // namespace HWY_NAMESPACE
}  // namespace penumbra
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace penumbra {

HWY_EXPORT(AddAndClear);
HWY_EXPORT(MergePlanes);
HWY_EXPORT(SubtractPlanes);

namespace {

// What four bitmaps are added to at once are two planes at least.
size_t PlaneCount(uint32_t most) { return std::max<size_t>(std::bit_width(most), 2); }

}  // namespace

BitmapCounter::BitmapCounter(uint32_t width, uint32_t rows, uint32_t most)
    : batch_{ShadowBitmap(width, rows), ShadowBitmap(width, rows), ShadowBitmap(width, rows),
             ShadowBitmap(width, rows)},
      planes_(PlaneCount(most), std::vector<uint32_t>(batch_[0].words.size())) {}

void BitmapCounter::CountNext() {
  const ShadowBitmap& bitmap = next();
  for (uint32_t c = 0; c < bitmap.columns; ++c) {
    if (bitmap.touched_rows_begin[c] >= bitmap.touched_rows_end[c]) continue;
    Touch(bitmap.touched_rows_begin[c], bitmap.touched_rows_end[c]);
  }
  if (++in_batch_ == kBatch) Finish();
}

void BitmapCounter::Finish() {
  if (in_batch_ > 0) HWY_DYNAMIC_DISPATCH(AddAndClear)(batch_, planes_);
  in_batch_ = 0;
}

void BitmapCounter::Merge(const BitmapCounter& other, uint32_t begin, uint32_t end) {
  HWY_DYNAMIC_DISPATCH(MergePlanes)(planes_, other.planes_, batch_[0].stride, begin, end);
}

void BitmapCounter::SubtractFrom(uint16_t* counts, uint32_t width, uint32_t begin,
                                 uint32_t end) const {
  HWY_DYNAMIC_DISPATCH(SubtractPlanes)(planes_, batch_[0].stride, begin, end, width, counts);
}

void BitmapCounter::Clear() {
  CountNext();  // what may have been drawn
  Finish();
  for (std::vector<uint32_t>& plane : planes_) {
    for (size_t column = 0; column < plane.size(); column += batch_[0].stride) {
      if (rows_begin_ < rows_end_) {
        std::fill_n(plane.data() + column + rows_begin_, rows_end_ - rows_begin_, 0u);
      }
    }
  }
  rows_begin_ = std::numeric_limits<uint32_t>::max();
  rows_end_ = 0;
}

void BitmapCounters::Prepare(size_t threads, uint32_t width, uint32_t rows, uint32_t most) {
  if (width != width_ || rows > rows_ || most > most_) {
    counters_.clear();
    width_ = width;
    rows_ = rows;
    most_ = most;
  }
  if (counters_.size() < threads) counters_.resize(threads);
}

size_t BitmapCounters::Bytes(size_t threads, uint32_t width, uint32_t rows, uint32_t most) {
  const size_t words = size_t{(width + 31) / 32} * (rows + ShadowBitmap::kRowPadding);
  return threads * sizeof(uint32_t) * words * (BitmapCounter::kBatch + PlaneCount(most));
}

BitmapCounter& BitmapCounters::Of(size_t thread) {
  std::unique_ptr<BitmapCounter>& counter = counters_[thread];
  if (!counter) counter = std::make_unique<BitmapCounter>(width_, rows_, most_);
  return *counter;
}

}  // namespace penumbra
#endif  // HWY_ONCE
