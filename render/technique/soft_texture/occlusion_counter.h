// Counts, for each texel of a receiver, the light samples that occluders leave to it.
//
//   OcclusionCounter counter(scene, light, receiver, surface_offset, {.method = …});
//   counter.CountDown(std::vector<uint16_t>(width * height, samples.size()));
//   if (auto status = counter.Add(samples, arena, stop); !status.ok()) return status;
//   counter.counts()
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "render/scene/light_sample.h"
#include "render/scene/receiver.h"
#include "render/scene/scene.h"
#include "render/technique/soft_texture/coverage_kernel.h"
#include "render/technique/soft_texture/hard_shadow.h"
#include "render/technique/soft_texture/kept_shadows.h"
#include "render/technique/soft_texture/occluder_set.h"
#include "render/technique/soft_texture/receiver_transform.h"
#include "render/technique/soft_texture/sample_sum.h"
#include "tbb/task_arena.h"

namespace penumbra {

class OcclusionCounter {
 public:
  // Occluders within `surface_offset` metres of the receiver's plane do not count, nor does a
  // sample that is as near to it: nothing hides it.
  //
  // All samples that are added are of `light`. Refers to `scene`.
  OcclusionCounter(const Scene& scene, const AreaLight& light, const ReceiverPatch& receiver,
                   double surface_offset, const ShadowRules& rules, CasterChoice casters = {});
  OcclusionCounter(const OcclusionCounter&) = delete;
  OcclusionCounter& operator=(const OcclusionCounter&) = delete;

  // From now on each sample's shadow is also put into `shadows`, at the sample's number; the next
  // sample has number `next`.
  void StoreIn(SampleShadows& shadows, uint32_t next) {
    stored_in_ = &shadows;
    added_ = next;
  }
  // From now on what is hidden in `shadows` does not count.
  void CountBeyond(const SampleShadows& shadows) { beyond_ = &shadows; }
  // From now on `sum` gets all samples, hidden where drawn here or in what is counted beyond.
  void SumInto(SampleSum& sum) { sum_ = &sum; }

  // From now on sample number k is drawn with the outlines that `lenders[k]` sees, which must go on
  // to exist; with its own if that one is on the receiver's other side.
  void BorrowOutlines(std::span<const LightSample> lenders) { lenders_ = lenders; }
  // From now on threads count with what is in `counters`, and leave theirs there for others.
  void CountWith(BitmapCounters& counters) { counters_ = &counters; }
  // Every sample that a texel does not see takes one off its count, from now on off `counts`, H·W,
  // row by row; before off 0, modulo 2¹⁶.
  void CountDown(std::vector<uint16_t> counts) { counts_ = std::move(counts); }

  // Adds what hides `samples`. The result depends on neither the arena's size nor how samples are
  // split into calls.
  //
  // Errors  kCancelled: stop requested, asked once a sample; the counts are then of no use
  // Cost    O(samples · (triangles + texels drawn / 32))
  absl::Status Add(std::span<const LightSample> samples, tbb::task_arena& arena,
                   const std::stop_token& stop);

  // H·W, row by row; none before the first call of Add or CountDown.
  const std::vector<uint16_t>& counts() const { return counts_; }
  // The same; counting begins anew, at 0.
  std::vector<uint16_t> TakeCounts() { return std::exchange(counts_, {}); }

 private:
  // A sample's map, and the occluders on its side of the receiver.
  struct Job {
    uint32_t number;  // of the sample, over all calls of Add
    LightSample sample;
    LightSample lender;  // the sample whose outlines it uses, most often itself
    ReceiverTransform map;
    const OccluderSet* occluders;
    int side;  // 0: in front of the receiver, 1: behind it
  };

  using Outlines = std::array<std::vector<SeenOutline>, 2>;  // of either side

  // Prepared on first use, for samples of which `map` is one's.
  const OccluderSet& OccludersOn(int side, const ReceiverTransform& map,
                                 const std::stop_token& stop);
  LightSample LenderTo(uint32_t number, const LightSample& sample, bool is_in_front) const;
  std::vector<Job> JobsFor(std::span<const LightSample> samples, const std::stop_token& stop);
  // Puts neighbours on the light one after another, and returns where each group of them begins,
  // and the end.
  static std::vector<size_t> GroupNeighbours(std::vector<Job>& jobs, size_t group_size);
  Outlines OutlinesFor(const std::vector<Job>& jobs, tbb::task_arena& arena) const;
  // Draws and counts the jobs of one group; another thread has other counters.
  void AddGroup(std::span<const Job> group, const Outlines& outlines, const TexelWindow& window,
                HardShadow& shadow, BitmapCounter& counter, const std::stop_token& stop);
  // Takes what all jobs hide off the counts of the window's rows; leaves them as they are once
  // stopped.
  void AddBand(const std::vector<Job>& jobs, const std::vector<size_t>& groups,
               const Outlines& outlines, const TexelWindow& window, int worker_count,
               const std::stop_token& stop);
  void SumBand(std::span<const LightSample> samples, const TexelWindow& window,
               const std::stop_token& stop);

  const Scene& scene_;
  ReceiverPatch receiver_;
  double surface_offset_;
  ShadowRules rules_;
  CasterChoice casters_;
  std::optional<ShadowRegion> region_;  // where culling is wanted
  SampleShadows* stored_in_ = nullptr;
  const SampleShadows* beyond_ = nullptr;
  SampleSum* sum_ = nullptr;
  std::span<const LightSample> lenders_;
  BitmapCounters own_counters_, *counters_ = &own_counters_;
  std::optional<SampleShadows> band_;  // what was drawn of a band, for the sum
  uint32_t added_ = 0;                 // the next sample's number
  uint32_t band_first_ = 0;            // that of the first of this call of Add
  std::array<std::unique_ptr<OccluderSet>, 2>
      occluders_;                 // on the front, on the back; made on first use
  std::vector<uint16_t> counts_;  // empty: zeros
};

}  // namespace penumbra
