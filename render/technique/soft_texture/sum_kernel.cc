#include "render/technique/soft_texture/sum_kernel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/technique/soft_texture/sum_kernel.cc"
#include "hwy/foreach_target.h"  // compiles this file once for each target
#include "hwy/highway.h"
#include "render/technique/soft_texture/coverage_kernel.h"

HWY_BEFORE_NAMESPACE();
namespace penumbra {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using F = hn::CappedTag<float, kMaxLanes>;
using U = hn::RebindToUnsigned<F>;
using VF = hn::Vec<F>;
using VU = hn::Vec<U>;

constexpr uint32_t kWordBits = 32;

// One register of texels of a word: their distance from texel 0, their bits, and their sums.
struct Texels {
  VF along;
  VU bit;
  VF visible, all;
};

HWY_INLINE Texels LoadTexels(const SumRow& sums, uint32_t first, float step) {
  const F f;
  const U u;
  const VF zero = hn::Zero(f);
  const VF index = hn::Add(hn::Set(f, static_cast<float>(first)), hn::Iota(f, 0));
  return {hn::Mul(index, hn::Set(f, step)), hn::Shl(hn::Set(u, 1u), hn::Iota(u, first % kWordBits)),
          hn::LoadU(f, sums.visible + first), sums.all ? hn::LoadU(f, sums.all + first) : zero};
}

HWY_INLINE void StoreTexels(const Texels& texels, uint32_t first, const SumRow& sums) {
  const F f;
  hn::StoreU(texels.visible, f, sums.visible + first);
  if (sums.all) hn::StoreU(texels.all, f, sums.all + first);
}

template <bool kTwoSided>
HWY_INLINE void AddTerm(const TermRow& term, uint32_t hidden, Texels& texels) {
  const F f;
  const U u;
  const VF t = hn::Sub(hn::Set(f, term.t), texels.along);
  const VF r2 = hn::MulAdd(t, t, hn::Set(f, term.k));
  const VF facing = hn::MulAdd(t, hn::Set(f, term.e_t), hn::Set(f, term.e));
  const VF emitted = kTwoSided ? hn::Abs(facing) : hn::Max(facing, hn::Zero(f));
  const VF sent = hn::Div(hn::Mul(hn::Set(f, term.weight), emitted), hn::Mul(r2, r2));
  const auto is_hidden = hn::RebindMask(f, hn::TestBit(hn::Set(u, hidden), texels.bit));
  texels.visible = hn::Add(texels.visible, hn::IfThenZeroElse(is_hidden, sent));
  texels.all = hn::Add(texels.all, sent);
}

HWY_INLINE uint32_t HiddenWord(const HiddenRow& row, size_t sample, size_t column) {
  if (row.words == nullptr) return 0;
  return row.words[sample * row.sample_stride + column * row.column_stride];
}

template <bool kTwoSided>
void AddTerms(std::span<const TermRow> terms, float step, const HiddenRow& hidden,
              const HiddenRow& hidden_too, const SumRow& sums, uint32_t columns) {
  const auto lanes = static_cast<uint32_t>(hn::Lanes(F()));
  for (uint32_t column = 0; column < columns; ++column) {
    // Two registers at a time hide each other's latency.
    for (uint32_t first = column * kWordBits; first < (column + 1) * kWordBits;
         first += 2 * lanes) {
      Texels a = LoadTexels(sums, first, step), b = LoadTexels(sums, first + lanes, step);
      for (size_t s = 0; s < terms.size(); ++s) {
        if (terms[s].weight == 0) continue;
        const uint32_t word = HiddenWord(hidden, s, column) | HiddenWord(hidden_too, s, column);
        if (word == ~0u && !sums.all) continue;
        AddTerm<kTwoSided>(terms[s], word, a);
        AddTerm<kTwoSided>(terms[s], word, b);
      }
      StoreTexels(a, first, sums);
      StoreTexels(b, first + lanes, sums);
    }
  }
}

void AddTermRow(std::span<const TermRow> terms, const TermRule& rule, const HiddenRow& hidden,
                const HiddenRow& hidden_too, const SumRow& sums, uint32_t columns) {
  if (rule.two_sided) {
    AddTerms<true>(terms, rule.step, hidden, hidden_too, sums, columns);
  } else {
    AddTerms<false>(terms, rule.step, hidden, hidden_too, sums, columns);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace penumbra
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace penumbra {

HWY_EXPORT(AddTermRow);

void AddTermRow(std::span<const TermRow> terms, const TermRule& rule, const HiddenRow& hidden,
                const HiddenRow& hidden_too, const SumRow& sums, uint32_t columns) {
  HWY_DYNAMIC_DISPATCH(AddTermRow)(terms, rule, hidden, hidden_too, sums, columns);
}

}  // namespace penumbra
#endif  // HWY_ONCE
