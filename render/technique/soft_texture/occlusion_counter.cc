#include "render/technique/soft_texture/occlusion_counter.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <limits>
#include <optional>
#include <utility>

#include "render/math/box_tree.h"
#include "render/math/parallel_for.h"
#include "render/technique/soft_texture/bit_counters.h"
#include "render/technique/soft_texture/hard_shadow.h"

namespace penumbra {
namespace {

// A band's bitmap should stay in a core's second-level cache together with its counters.
constexpr uint32_t kBandWords = 1u << 13;

// Samples for which the edges of outlines are narrowed down together: with twice as many there are
// more edges to look at for each, with half as many the choice is made more often.
constexpr size_t kNeighbours = 8;

OutlineRule RuleFor(VisibilityMethod method) {
  if (method == VisibilityMethod::kSilhouette) return OutlineRule::kWherePossible;
  if (method == VisibilityMethod::kAuto) return OutlineRule::kWhereCheaper;
  return OutlineRule::kNever;
}

// One thread's share: a bitmap for the sample at hand, and the counters of all its samples.
struct Worker {
  Worker(const ReceiverPatch& receiver, const ShadowRules& rules, uint32_t rows,
         uint32_t plane_count)
      : shadow(receiver, rules), bitmap(receiver.width, rows), planes(plane_count) {
    for (auto& plane : planes) plane.resize(bitmap.words.size());
  }

  HardShadow shadow;
  ShadowBitmap bitmap;
  std::vector<std::vector<uint32_t>> planes;
  // Rows of the window that any of its samples' shadows lies in.
  uint32_t rows_begin = std::numeric_limits<uint32_t>::max(), rows_end = 0;

  void CountBitmap() {
    for (uint32_t c = 0; c < bitmap.columns; ++c) {
      if (bitmap.touched_rows_begin[c] >= bitmap.touched_rows_end[c]) continue;
      rows_begin = std::min(rows_begin, bitmap.touched_rows_begin[c]);
      rows_end = std::max(rows_end, bitmap.touched_rows_end[c]);
    }
    AddAndClear(bitmap, planes);
  }
};

void AddCounts(std::span<const std::unique_ptr<Worker>> workers, const TexelWindow& window,
               uint16_t* counts) {
  constexpr uint32_t kRowsPerTask = 64;
  uint32_t rows_begin = window.row_end - window.row_begin, rows_end = 0;
  for (const auto& worker : workers) {
    if (!worker) continue;
    rows_begin = std::min(rows_begin, worker->rows_begin);
    rows_end = std::max(rows_end, std::min(worker->rows_end, window.row_end - window.row_begin));
  }
  if (rows_begin >= rows_end) return;
  ParallelFor((rows_end - rows_begin + kRowsPerTask - 1) / kRowsPerTask, [&](uint32_t task) {
    const uint32_t begin = rows_begin + task * kRowsPerTask;
    const uint32_t end = std::min(rows_end, begin + kRowsPerTask);
    for (uint32_t row = begin; row < end; ++row) {
      uint16_t* row_counts = counts + size_t{row} * window.width;
      for (const auto& worker : workers) {
        if (!worker) continue;
        AddRowCounts(worker->planes, worker->bitmap.stride, row, window.width, row_counts);
      }
    }
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
      casters_(casters),
      counts_(size_t{receiver.width} * receiver.height, uint16_t{0}) {
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

std::vector<OcclusionCounter::Job> OcclusionCounter::JobsFor(std::span<const LightSample> samples,
                                                             const std::stop_token& stop) {
  std::vector<Job> jobs;
  for (const LightSample& sample : samples) {
    const uint32_t number = added_++;
    const auto map = ReceiverTransform::Create(receiver_.patch, sample, surface_offset_);
    if (!map) continue;
    const bool is_in_front = map->sample_height() > 0;
    const OccluderSet& occluders = OccludersOn(is_in_front ? 1 : -1, *map, stop);
    if (!occluders.empty()) {
      jobs.push_back({number, sample, *map, &occluders, is_in_front ? 0 : 1});
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
      if (job.side == side) samples.push_back(job.sample);
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
      places.push_back({job.sample.point, job.sample.point});
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

void OcclusionCounter::AddBand(const std::vector<Job>& jobs, const std::vector<size_t>& groups,
                               const Outlines& outlines, const TexelWindow& window,
                               int worker_count, const std::stop_token& stop) {
  const auto plane_count = static_cast<uint32_t>(std::bit_width(jobs.size()));
  std::vector<std::unique_ptr<Worker>> workers(worker_count);
  std::atomic<size_t> next{0};
  const auto add_group = [&](Worker& worker, std::span<const Job> group) {
    const std::vector<SeenOutline>& seen = outlines[group.front().side];
    if (!seen.empty()) {
      std::vector<LightSample> samples;
      for (const Job& job : group) samples.push_back(job.sample);
      worker.shadow.NarrowTo(samples, *group.front().occluders, seen);
    }
    for (const Job& job : group) {
      if (stop.stop_requested()) return;
      worker.shadow.Draw(*job.occluders, seen, job.sample, job.map, window, worker.bitmap);
      if (stored_in_) stored_in_->Store(job.number, window.row_begin, worker.bitmap);
      if (band_) band_->Store(job.number - band_first_, 0, worker.bitmap);
      if (beyond_) beyond_->Subtract(job.number, window.row_begin, worker.bitmap);
      worker.CountBitmap();
    }
  };
  ParallelFor(worker_count, [&](int w) {
    for (size_t g = next++; g + 1 < groups.size() && !stop.stop_requested(); g = next++) {
      if (!workers[w]) {
        workers[w] = std::make_unique<Worker>(receiver_, rules_, window.row_end - window.row_begin,
                                              plane_count);
      }
      add_group(*workers[w], std::span(jobs).subspan(groups[g], groups[g + 1] - groups[g]));
    }
  });
  if (stop.stop_requested()) return;
  AddCounts(workers, window, counts_.data() + size_t{window.row_begin} * receiver_.width);
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
  std::vector<Job> jobs = JobsFor(samples, stop);
  const Outlines outlines = OutlinesFor(jobs, arena);
  const uint32_t columns = (receiver_.width + 31) / 32;
  const uint32_t band_rows = std::clamp(kBandWords / columns, 1u, receiver_.height);
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
