#include "render/technique/soft_texture/borrowed_outlines.h"

#include <algorithm>
#include <bit>
#include <numeric>

#include "render/math/box_tree.h"

namespace penumbra {
namespace {

// Light samples that are drawn both ways.
constexpr size_t kSamplesChecked = 4;

double Distance(const LightSample& a, const LightSample& b) {
  return glm::length(DVec3(a.point) - DVec3(b.point));
}

}  // namespace

std::vector<LightSample> OutlineLenders(std::span<const LightSample> samples, uint32_t group_size) {
  std::vector<Aabb> places;
  for (const LightSample& sample : samples) places.push_back({sample.point, sample.point});
  std::vector<LightSample> lenders(samples.begin(), samples.end());
  BoxTree(places, group_size).VisitLeaves([&](std::span<const uint32_t> leaf) {
    Aabb box;
    for (const uint32_t s : leaf) box.Add(samples[s].point);
    const auto from_middle = [&](uint32_t s) {
      return glm::length(DVec3(samples[s].point) - DVec3(box.center()));
    };
    const uint32_t lender = *std::ranges::min_element(leaf, {}, from_middle);
    for (const uint32_t s : leaf) lenders[s] = samples[lender];
  });
  return lenders;
}

std::vector<uint32_t> FurthestFromLenders(std::span<const LightSample> samples,
                                          std::span<const LightSample> lenders, size_t most) {
  std::vector<uint32_t> numbers(samples.size());
  std::iota(numbers.begin(), numbers.end(), 0u);
  std::ranges::stable_sort(numbers, std::ranges::greater(),
                           [&](uint32_t s) { return Distance(samples[s], lenders[s]); });
  numbers.resize(std::min(most, numbers.size()));
  return numbers;
}

absl::StatusOr<double> BorrowingError(OcclusionCounter& exact, OcclusionCounter& borrowing,
                                      std::span<const LightSample> samples,
                                      std::span<const LightSample> lenders,
                                      const CoverageMask* inside, const ReceiverPatch& receiver,
                                      tbb::task_arena& arena, const std::stop_token& stop) {
  std::vector<LightSample> checked, theirs;
  for (const uint32_t s : FurthestFromLenders(samples, lenders, kSamplesChecked)) {
    checked.push_back(samples[s]);
    theirs.push_back(lenders[s]);
  }
  const auto count = static_cast<uint32_t>(checked.size());
  SampleShadows right(receiver.width, receiver.height, count), wrong = right;
  exact.StoreIn(right, 0);
  borrowing.StoreIn(wrong, 0);
  borrowing.BorrowOutlines(theirs);
  for (OcclusionCounter* const counter : {&exact, &borrowing}) {
    if (const auto status = counter->Add(checked, arena, stop); !status.ok()) return status;
  }
  return LargestDifference(right, wrong, count, receiver.width, receiver.height, inside);
}

double LargestDifference(const SampleShadows& a, const SampleShadows& b, uint32_t count,
                         uint32_t width, uint32_t height, const CoverageMask* inside) {
  const auto is_inside = [&](size_t texel) { return inside == nullptr || inside->At(texel); };
  size_t texels = 0, largest = 0;
  for (size_t texel = 0; texel < size_t{width} * height; ++texel) texels += is_inside(texel);
  for (uint32_t sample = 0; sample < count; ++sample) {
    size_t differing = 0;
    for (uint32_t row = 0; row < height; ++row) {
      const uint32_t* const in_a = a.Row(sample, row);
      const uint32_t* const in_b = b.Row(sample, row);
      for (uint32_t column = 0; 32 * column < width; ++column) {
        const size_t word = column * a.column_stride();
        for (uint32_t bits = in_a[word] ^ in_b[word]; bits != 0; bits &= bits - 1) {
          const uint32_t bit = static_cast<uint32_t>(std::countr_zero(bits));
          differing += is_inside(size_t{row} * width + 32 * column + bit);
        }
      }
    }
    largest = std::max(largest, differing);
  }
  return texels == 0 ? 0 : static_cast<double>(largest) / static_cast<double>(texels);
}

}  // namespace penumbra
