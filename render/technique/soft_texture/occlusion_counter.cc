#include "render/technique/soft_texture/occlusion_counter.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <optional>
#include <utility>

#include "absl/cleanup/cleanup.h"
#include "render/math/box_tree.h"
#include "render/math/parallel_for.h"
#include "render/technique/soft_texture/bit_counters.h"
#include "render/technique/soft_texture/hard_shadow.h"

namespace penumbra {
namespace {

// Samples whose outlines are found together: with twice as many more edges are looked at for
// nothing, with half as many each edge is asked about more often.
constexpr size_t kNeighbours = 8;

// Texels whose counts one task adds: fewer take less time than handing them over.
constexpr uint32_t kTexelsPerTask = 1u << 15;

OutlineRule RuleFor(VisibilityMethod method) {
  if (method == VisibilityMethod::kSilhouette) return OutlineRule::kWherePossible;
  if (method == VisibilityMethod::kAuto) return OutlineRule::kWhereCheaper;
  return OutlineRule::kNever;
}

// Takes what `counters` have counted off `counts`, the window's first texel's and on.
void SubtractCounts(std::span<BitmapCounter* const> counters, const TexelWindow& window,
                    uint16_t* counts) {
  uint32_t rows_begin = window.row_end - window.row_begin, rows_end = 0;
  for (BitmapCounter* const counter : counters) {
    counter->Finish();
    rows_begin = std::min(rows_begin, counter->rows_begin());
    rows_end = std::max(rows_end, counter->rows_end());
  }
  if (rows_begin >= rows_end) return;
  counters[0]->Touch(rows_begin, rows_end);
  constexpr uint32_t kStep = BitmapCounter::kRowStep;
  const uint32_t rows_per_task = (kTexelsPerTask / window.width / kStep + 1) * kStep;
  ParallelFor((rows_end - rows_begin + rows_per_task - 1) / rows_per_task, [&](uint32_t task) {
    const uint32_t begin = rows_begin + task * rows_per_task;
    const uint32_t end = std::min(rows_end, begin + rows_per_task);
    for (BitmapCounter* const other : counters.subspan(1)) counters[0]->Merge(*other, begin, end);
    counters[0]->SubtractFrom(counts, window.width, begin, end);
  });
}

// Whether the hull of light and receiver can say of anything that it need not be looked at: what is
// asked for by name is, and small meshes are drawn whole.
bool MayLeaveOut(const Scene& scene, const CasterChoice& casters) {
  if (!casters.ids || casters.all_but_ids) return true;
  return std::any_of(casters.ids->begin(), casters.ids->end(), [&](const std::string& id) {
    const auto instance = scene.FindInstance(id);
    return instance && instance->mesh->triangle_count() > kClusterTriangles;
  });
}

}  // namespace

OcclusionCounter::OcclusionCounter(const Scene& scene, const AreaLight& light,
                                   const ReceiverPatch& receiver, double surface_offset,
                                   const ShadowRules& rules, CasterChoice casters)
    : scene_(scene),
      receiver_(receiver),
      surface_offset_(surface_offset),
      rules_(rules),
      casters_(casters) {
  if (rules.cull && MayLeaveOut(scene, casters)) region_.emplace(light, receiver.patch);
}

const OccluderSet& OcclusionCounter::OccludersOn(int side, const ReceiverTransform& map,
                                                 const std::stop_token& stop) {
  auto& set = occluders_[side > 0 ? 0 : 1];
  if (!set) {
    OccluderFrame frame(receiver_.patch, side, surface_offset_);
    if (region_) frame.region = &*region_;
    set = std::make_unique<OccluderSet>(PrepareOccluders(scene_, frame,
                                                         {map, receiver_.width, receiver_.height},
                                                         RuleFor(rules_.method), casters_, stop));
  }
  return *set;
}

LightSample OcclusionCounter::LenderTo(uint32_t number, const LightSample& sample,
                                       bool is_in_front) const {
  if (number >= lenders_.size()) return sample;
  const LightSample& lender = lenders_[number];
  const auto map = ReceiverTransform::Create(receiver_.patch, lender, surface_offset_);
  return map && (map->sample_height() > 0) == is_in_front ? lender : sample;
}

std::vector<OcclusionCounter::Job> OcclusionCounter::JobsFor(std::span<const LightSample> samples,
                                                             const std::stop_token& stop) {
  std::vector<Job> jobs;
  jobs.reserve(samples.size());
  for (const LightSample& sample : samples) {
    const uint32_t number = added_++;
    const auto map = ReceiverTransform::Create(receiver_.patch, sample, surface_offset_);
    if (!map) continue;
    const bool is_in_front = map->sample_height() > 0;
    const OccluderSet& occluders = OccludersOn(is_in_front ? 1 : -1, *map, stop);
    if (!occluders.empty()) {
      jobs.push_back({.number = number,
                      .sample = sample,
                      .lender = LenderTo(number, sample, is_in_front),
                      .map = *map,
                      .occluders = &occluders,
                      .side = is_in_front ? 0 : 1});
    }
  }
  return jobs;
}

OcclusionCounter::Outlines OcclusionCounter::OutlinesFor(const std::vector<Job>& jobs,
                                                         tbb::task_arena& arena) const {
  Outlines outlines;
  for (int side = 0; side < 2; ++side) {
    std::vector<LightSample> samples;
    for (const Job& job : jobs) {
      if (job.side == side) samples.push_back(job.lender);
    }
    if (!samples.empty() && !occluders_[side]->outlined.empty()) {
      outlines[side] = OutlinesSeenFrom(occluders_[side]->outlined, samples, arena);
    }
  }
  return outlines;
}

std::vector<size_t> OcclusionCounter::GroupNeighbours(std::vector<Job>& jobs, size_t group_size) {
  std::vector<size_t> begins = {0};
  if (group_size <= 1) {
    for (size_t j = 1; j <= jobs.size(); ++j) begins.push_back(j);
    return begins;
  }
  std::vector<Job> ordered;
  ordered.reserve(jobs.size());
  for (int side = 0; side < 2; ++side) {
    std::vector<const Job*> of_side;
    std::vector<Aabb> places;
    for (const Job& job : jobs) {
      if (job.side != side) continue;
      of_side.push_back(&job);
      places.push_back({job.lender.point, job.lender.point});
    }
    BoxTree(places, static_cast<uint32_t>(group_size))
        .VisitLeaves([&](std::span<const uint32_t> leaf) {
          for (const uint32_t j : leaf) ordered.push_back(*of_side[j]);
          begins.push_back(ordered.size());
        });
  }
  jobs = std::move(ordered);
  return begins;
}

void OcclusionCounter::AddGroup(std::span<const Job> group, const Outlines& outlines,
                                const TexelWindow& window, HardShadow& shadow,
                                BitmapCounter& counter, const std::stop_token& stop) {
  const std::vector<SeenOutline>& seen = outlines[group.front().side];
  if (!seen.empty()) {
    std::vector<LightSample> lenders;
    for (const Job& job : group) lenders.push_back(job.lender);
    shadow.FindOutlines(lenders, *group.front().occluders, seen);
  }
  for (size_t neighbour = 0; neighbour < group.size(); ++neighbour) {
    const Job& job = group[neighbour];
    if (stop.stop_requested()) return;
    ShadowBitmap& bitmap = counter.next();
    shadow.Draw(*job.occluders, seen, job.sample, neighbour, job.map, window, bitmap);
    if (stored_in_) stored_in_->Store(job.number, window.row_begin, bitmap);
    if (band_) band_->Store(job.number - band_first_, 0, bitmap);
    if (beyond_) beyond_->Subtract(job.number, window.row_begin, bitmap);
    counter.CountNext();
  }
}

void OcclusionCounter::AddBand(const std::vector<Job>& jobs, const std::vector<size_t>& groups,
                               const Outlines& outlines, const TexelWindow& window,
                               int worker_count, const std::stop_token& stop) {
  counters_->Prepare(worker_count, receiver_.width, window.row_end - window.row_begin,
                     static_cast<uint32_t>(jobs.size()));
  // Should memory run out on the way, what is half drawn must not be found by the next computation.
  absl::Cleanup drop = [this] { counters_->Drop(); };
  std::vector<std::optional<HardShadow>> shadows(worker_count);  // made by who gets a group
  std::atomic<size_t> next{0};
  ParallelFor(worker_count, [&](int w) {
    for (size_t g = next++; g + 1 < groups.size() && !stop.stop_requested(); g = next++) {
      if (!shadows[w]) shadows[w].emplace(receiver_, rules_);
      AddGroup(std::span(jobs).subspan(groups[g], groups[g + 1] - groups[g]), outlines, window,
               *shadows[w], counters_->Of(w), stop);
    }
  });
  std::vector<BitmapCounter*> used;
  for (int w = 0; w < worker_count; ++w) {
    if (shadows[w]) used.push_back(&counters_->Of(w));
  }
  if (!stop.stop_requested()) {
    SubtractCounts(used, window, counts_.data() + size_t{window.row_begin} * receiver_.width);
  }
  for (BitmapCounter* const counter : used) counter->Clear();
  std::move(drop).Cancel();
}

void OcclusionCounter::SumBand(std::span<const LightSample> samples, const TexelWindow& window,
                               const std::stop_token& stop) {
  const BandShadows drawn{.shadows = band_ ? &*band_ : nullptr, .first_row = window.row_begin};
  const BandShadows kept{.shadows = beyond_, .first_sample = band_first_};
  sum_->AddBand(samples, window, drawn, kept, stop);
}

absl::Status OcclusionCounter::Add(std::span<const LightSample> samples, tbb::task_arena& arena,
                                   const std::stop_token& stop) {
  band_first_ = added_;
  if (counts_.empty()) counts_.resize(size_t{receiver_.width} * receiver_.height);
  std::vector<Job> jobs = JobsFor(samples, stop);
  const Outlines outlines = OutlinesFor(jobs, arena);
  const uint32_t band_rows = BandRows(receiver_.width, receiver_.height);
  const int worker_count = std::min(arena.max_concurrency(), static_cast<int>(jobs.size()));
  // Every thread should have two groups at least; without outlines there is nothing to share.
  const bool has_outlines = !outlines[0].empty() || !outlines[1].empty();
  const size_t group_size =
      has_outlines
          ? std::clamp<size_t>(jobs.size() / (2 * std::max(worker_count, 1)), 1, kNeighbours)
          : 1;
  const std::vector<size_t> groups = GroupNeighbours(jobs, group_size);
  const bool is_idle = jobs.empty() && !sum_;
  for (uint32_t row = 0; row < receiver_.height && !is_idle; row += band_rows) {
    const TexelWindow window{receiver_.width, row, std::min(row + band_rows, receiver_.height)};
    if (sum_ && !jobs.empty()) {
      band_.emplace(receiver_.width, window.row_end - row, static_cast<uint32_t>(samples.size()));
    }
    RunIn(arena, [&] {
      if (!jobs.empty()) AddBand(jobs, groups, outlines, window, worker_count, stop);
      if (sum_) SumBand(samples, window, stop);
    });
    band_.reset();
    if (stop.stop_requested()) break;
  }
  return stop.stop_requested() ? absl::CancelledError("stop requested") : absl::OkStatus();
}

}  // namespace penumbra
