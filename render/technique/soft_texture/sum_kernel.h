// Adding up what the samples of a light send to a row of texels, equation 3.2.
//
//   AddTermRow(terms, {.step = step}, {.words = hidden, …}, {}, {visible, nullptr}, columns);
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace penumbra {

// A sample as a row of texels sees it. With t the distance along the row from texel to sample, what
// the sample sends to a texel is
//
//   weight · emitted(t) / (k + t²)²,   emitted(t) = e + e_t · t
//
// where k + t² is the squared distance r², and emitted(t) is r cos θ' (negative: seen from behind).
struct TermRow {
  float t;       // at texel 0, m
  float k;       // m²
  float e;       // m
  float e_t;     // in [-1, 1]
  float weight;  // a cos θ r / π; 0: the sample sends nothing here
};

struct TermRule {
  float step;      // from a texel's centre to the next, m
  bool two_sided;  // the light shines from both faces: |emitted| counts, otherwise max(0, …)
};

// The words of one row in which a set bit hides a sample from a texel; null: nothing is hidden.
struct HiddenRow {
  const uint32_t* words = nullptr;  // of sample 0, column 0
  size_t sample_stride = 0;
  size_t column_stride = 0;
};

// 32 floats a column of words each.
struct SumRow {
  float* visible;  // gets what is hidden by neither
  float* all;      // gets everything; may be null
};

// Adds terms[0], terms[1], … in this order at every texel, so that sums do not depend on how rows
// are shared among threads. Rounding: a term is good to 2⁻²¹ of its value and as much as moving the
// texel by 2⁻²³ of the row's length changes; a sum of n terms to n · 2⁻²⁴ more.
void AddTermRow(std::span<const TermRow> terms, const TermRule& rule, const HiddenRow& hidden,
                const HiddenRow& hidden_too, const SumRow& sums, uint32_t columns);

}  // namespace penumbra
