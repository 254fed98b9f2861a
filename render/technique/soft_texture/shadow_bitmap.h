// One bit a texel: whether the texel is in the hard shadow of one light sample.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace penumbra {

// Words of 32 texels, stored column of words by column of words, so that the same word of
// consecutive rows is consecutive in memory: a vector register holds 32 texels of up to 16 rows.
struct ShadowBitmap {
  // A vector may reach past the last row.
  static constexpr uint32_t kRowPadding = 16;

  ShadowBitmap(uint32_t width, uint32_t height)
      : columns((width + 31) / 32),
        stride(height + kRowPadding),
        words(size_t{columns} * stride, 0u),
        touched_rows_begin(columns, height),
        touched_rows_end(columns, 0) {}

  uint32_t* Column(uint32_t column) { return words.data() + size_t{column} * stride; }
  const uint32_t* Column(uint32_t column) const { return words.data() + size_t{column} * stride; }

  void Touch(uint32_t column_begin, uint32_t column_end, uint32_t row_begin, uint32_t row_end) {
    for (uint32_t c = column_begin; c < column_end; ++c) {
      touched_rows_begin[c] = std::min(touched_rows_begin[c], row_begin);
      touched_rows_end[c] = std::max(touched_rows_end[c], row_end);
    }
  }

  uint32_t columns;
  uint32_t stride;
  std::vector<uint32_t> words;
  // Outside these rows a column is all zeros.
  std::vector<uint32_t> touched_rows_begin, touched_rows_end;
};

}  // namespace penumbra
