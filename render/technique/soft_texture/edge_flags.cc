#include "render/technique/soft_texture/edge_flags.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/technique/soft_texture/edge_flags.cc"
#include "hwy/foreach_target.h"  // compiles this file once for each target
#include "hwy/highway.h"
#include "render/technique/soft_texture/kernel_rows-inl.h"

HWY_BEFORE_NAMESPACE();
namespace penumbra {
namespace HWY_NAMESPACE {

// A batch of edges that cross rows of the window, lowest row first.
struct EdgeBatch {
  HWY_ALIGN float x_low[kMaxLanes], y_low[kMaxLanes], slope[kMaxLanes];
  HWY_ALIGN int32_t row_begin[kMaxLanes], row_end[kMaxLanes];
  HWY_ALIGN int32_t column[kMaxLanes];  // in row_begin
  HWY_ALIGN int32_t weight[kMaxLanes];
};

HWY_INLINE VI ColumnsIn(VF y, VF x_low, VF y_low, VF slope, VI last) {
  const VI column = CeilToInt(hn::MulAdd(hn::Sub(y, y_low), slope, x_low));
  return hn::Min(hn::Max(column, hn::Zero(I())), last);
}

// Lanes past the first `valid` take vertex 0: whatever lies past a list's end is no vertex.
HWY_INLINE Projected Gathered(const VertexArrays& vertices, const uint32_t* index, size_t valid,
                              const TexelProjection& projection) {
  const F f;
  const VI i = hn::IfThenElseZero(hn::FirstN(I(), valid),
                                  hn::LoadU(I(), reinterpret_cast<const int32_t*>(index)));
  return Project(hn::GatherIndex(f, vertices.x, i), hn::GatherIndex(f, vertices.y, i),
                 hn::GatherIndex(f, vertices.z, i), projection);
}

// Which of the edges cross a row of the window, as bits; they are stored.
HWY_INLINE uint32_t SelectEdges(const VertexArrays& vertices, const EdgeList& edges, size_t e,
                                int32_t sign, const TexelProjection& projection,
                                const TexelWindow& window, EdgeBatch& batch) {
  const F f;
  const I i;
  Corners low = Gathered(vertices, edges.from + e, edges.count - e, projection).texel;
  Corners high = Gathered(vertices, edges.to + e, edges.count - e, projection).texel;
  const auto runs_down = hn::Gt(low.y, high.y);
  const Corners from = low;
  low = {hn::IfThenElse(runs_down, high.x, from.x), hn::IfThenElse(runs_down, high.y, from.y)};
  high = {hn::IfThenElse(runs_down, from.x, high.x), hn::IfThenElse(runs_down, from.y, high.y)};
  const VF begin = hn::Max(hn::Ceil(low.y), hn::Set(f, static_cast<float>(window.row_begin)));
  const VF end = hn::Min(hn::Ceil(high.y), hn::Set(f, static_cast<float>(window.row_end)));
  const auto crosses = hn::And(hn::Lt(begin, end), hn::FirstN(f, edges.count - e));
  const uint32_t bits = Bits(crosses);
  if (bits == 0) return 0;
  const VF slope = SlopeBetween(low, high);
  const VI weight = hn::Mul(hn::LoadU(i, edges.weight + e), hn::Set(i, sign));
  hn::Store(low.x, f, batch.x_low);
  hn::Store(low.y, f, batch.y_low);
  hn::Store(slope, f, batch.slope);
  hn::Store(hn::ConvertTo(i, begin), i, batch.row_begin);
  hn::Store(hn::ConvertTo(i, end), i, batch.row_end);
  hn::Store(ColumnsIn(begin, low.x, low.y, slope, hn::Set(i, static_cast<int32_t>(window.width))),
            i, batch.column);
  hn::Store(hn::IfThenElse(hn::RebindMask(i, runs_down), hn::Neg(weight), weight), i, batch.weight);
  return bits;
}

// The flags of one row's worth of columns; what is right of the window is left out.
HWY_INLINE void FlagRow(int32_t column, uint32_t row, int32_t weight, EdgeFlags& flags,
                        int32_t& leftmost, int32_t& rightmost) {
  if (column >= static_cast<int32_t>(flags.width)) return;
  flags.change[static_cast<size_t>(column) * flags.stride + row] += weight;
  leftmost = std::min(leftmost, column);
  rightmost = std::max(rightmost, column);
}

void FlagEdges(const VertexArrays& vertices, const EdgeList& edges, int32_t sign,
               const TexelProjection& projection, const TexelWindow& window, EdgeFlags& flags) {
  const F f;
  const I i;
  EdgeBatch batch = {};
  const VI last = hn::Set(i, static_cast<int32_t>(window.width));
  int32_t leftmost = static_cast<int32_t>(window.width), rightmost = -1;
  uint32_t lowest = window.row_end, highest = window.row_begin;
  for (size_t e = 0; e < edges.count; e += hn::Lanes(f)) {
    uint32_t bits = SelectEdges(vertices, edges, e, sign, projection, window, batch);
    for (; bits != 0; bits &= bits - 1) {
      const auto k = static_cast<size_t>(__builtin_ctz(bits));
      const auto begin = static_cast<uint32_t>(batch.row_begin[k]);
      const auto end = static_cast<uint32_t>(batch.row_end[k]);
      lowest = std::min(lowest, begin);
      highest = std::max(highest, end);
      FlagRow(batch.column[k], begin - window.row_begin, batch.weight[k], flags, leftmost,
              rightmost);
      for (uint32_t base = begin + 1; base < end; base += hn::Lanes(f)) {
        HWY_ALIGN int32_t columns[kMaxLanes];
        const VF y = hn::ConvertTo(f, hn::Iota(i, static_cast<int32_t>(base)));
        hn::Store(ColumnsIn(y, hn::Set(f, batch.x_low[k]), hn::Set(f, batch.y_low[k]),
                            hn::Set(f, batch.slope[k]), last),
                  i, columns);
        const uint32_t rows = std::min<uint32_t>(end - base, hn::Lanes(f));
        for (uint32_t r = 0; r < rows; ++r) {
          FlagRow(columns[r], base + r - window.row_begin, batch.weight[k], flags, leftmost,
                  rightmost);
        }
      }
    }
  }
  if (rightmost < 0) return;
  flags.Touch(static_cast<uint32_t>(leftmost), static_cast<uint32_t>(rightmost) + 1,
              lowest - window.row_begin, highest - window.row_begin);
}

void FillFromFlags(const TexelWindow& window, EdgeFlags& flags, ShadowBitmap& bitmap) {
  const I i;
  const U u;
  if (flags.rows_begin >= flags.rows_end) return;
  const uint32_t first_word = flags.columns_begin / 32;
  const uint32_t last_column = flags.columns_end;
  for (uint32_t row = flags.rows_begin; row < flags.rows_end; row += hn::Lanes(i)) {
    // A vector may reach past the last touched row, into rows whose flags are all zeros.
    VI sum = hn::Zero(i);
    for (uint32_t word = first_word; word < bitmap.columns; ++word) {
      const uint32_t columns = std::min(32u, window.width - 32 * word);
      VU filled = hn::Zero(u);
      uint32_t bit = 0;
      for (; bit < columns && 32 * word + bit < last_column; ++bit) {
        int32_t* const change = &flags.change[size_t{32 * word + bit} * flags.stride + row];
        sum = hn::Add(sum, hn::LoadU(i, change));
        hn::StoreU(hn::Zero(i), i, change);
        const auto inside = hn::RebindMask(u, hn::Ne(sum, hn::Zero(i)));
        filled = hn::Or(filled, hn::IfThenElseZero(inside, hn::Set(u, 1u << bit)));
      }
      if (bit < columns) {  // nothing changes from here on
        const uint32_t upto = columns == 32 ? ~0u : (1u << columns) - 1;
        const auto inside = hn::RebindMask(u, hn::Ne(sum, hn::Zero(i)));
        filled = hn::Or(filled, hn::IfThenElseZero(inside, hn::Set(u, upto & ~((1u << bit) - 1))));
      }
      uint32_t* const out = bitmap.Column(word) + row;
      hn::StoreU(hn::Or(hn::LoadU(u, out), filled), u, out);
    }
  }
  bitmap.Touch(first_word, bitmap.columns, flags.rows_begin, flags.rows_end);
  flags.rows_begin = flags.stride - ShadowBitmap::kRowPadding;
  flags.columns_begin = flags.width;
  flags.rows_end = flags.columns_end = 0;
}

}  // namespace HWY_NAMESPACE
}  // namespace penumbra
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace penumbra {

HWY_EXPORT(FlagEdges);
HWY_EXPORT(FillFromFlags);

void FlagEdges(const VertexArrays& vertices, const EdgeList& edges, int32_t sign,
               const TexelProjection& projection, const TexelWindow& window, EdgeFlags& flags) {
  HWY_DYNAMIC_DISPATCH(FlagEdges)(vertices, edges, sign, projection, window, flags);
}

void FillFromFlags(const TexelWindow& window, EdgeFlags& flags, ShadowBitmap& bitmap) {
  HWY_DYNAMIC_DISPATCH(FillFromFlags)(window, flags, bitmap);
}

}  // namespace penumbra
#endif  // HWY_ONCE
