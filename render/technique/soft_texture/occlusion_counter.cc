#include "render/technique/soft_texture/occlusion_counter.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <limits>
#include <optional>
#include <utility>

#include "render/math/parallel_for.h"
#include "render/technique/soft_texture/bit_counters.h"
#include "render/technique/soft_texture/hard_shadow.h"

namespace penumbra {
namespace {

// A band's bitmap should stay in a core's second-level cache together with its counters.
constexpr uint32_t kBandWords = 1u << 13;

// Fewer triangles are filled faster than their outline is found.
constexpr uint32_t kTrianglesWorthAnOutline = 256;

OutlineRule RuleFor(VisibilityMethod method) {
  if (method == VisibilityMethod::kSilhouette) return {.min_triangles = 0};
  if (method == VisibilityMethod::kAuto) return {.min_triangles = kTrianglesWorthAnOutline};
  return {};
}

// One thread's share: a bitmap for the sample at hand, and the counters of all its samples.
struct Worker {
  Worker(const ReceiverPatch& receiver, VisibilityMethod method, uint32_t rows,
         uint32_t plane_count)
      : shadow(receiver, method), bitmap(receiver.width, rows), planes(plane_count) {
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

}  // namespace

OcclusionCounter::OcclusionCounter(const Scene& scene, const ReceiverPatch& receiver,
                                   double surface_offset, VisibilityMethod method,
                                   CasterFilter casters)
    : scene_(scene),
      receiver_(receiver),
      surface_offset_(surface_offset),
      method_(method),
      casters_(std::move(casters)),
      counts_(size_t{receiver.width} * receiver.height, uint16_t{0}) {}

const OccluderSet& OcclusionCounter::OccludersOn(int side, const std::stop_token& stop) {
  auto& set = occluders_[side > 0 ? 0 : 1];
  if (!set) {
    set = std::make_unique<OccluderSet>(PrepareOccluders(
        scene_, receiver_.patch, side, surface_offset_, RuleFor(method_), casters_, stop));
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
    const OccluderSet& occluders = OccludersOn(is_in_front ? 1 : -1, stop);
    if (!occluders.groups.empty()) {
      jobs.push_back({number, sample, *map, &occluders, is_in_front ? 0 : 1});
    }
  }
  return jobs;
}

std::array<SeenOutlines, 2> OcclusionCounter::OutlinesFor(const std::vector<Job>& jobs,
                                                          tbb::task_arena& arena) const {
  std::array<SeenOutlines, 2> outlines;
  for (int side = 0; side < 2; ++side) {
    std::vector<LightSample> samples;
    for (const Job& job : jobs) {
      if (job.side == side) samples.push_back(job.sample);
    }
    if (!samples.empty()) outlines[side] = OutlinesSeenFrom(*occluders_[side], samples, arena);
  }
  return outlines;
}

void OcclusionCounter::AddBand(const std::vector<Job>& jobs,
                               const std::array<SeenOutlines, 2>& outlines,
                               const TexelWindow& window, int worker_count,
                               const std::stop_token& stop) {
  const auto plane_count = static_cast<uint32_t>(std::bit_width(jobs.size()));
  std::vector<std::unique_ptr<Worker>> workers(worker_count);
  std::atomic<size_t> next{0};
  ParallelFor(worker_count, [&](int w) {
    for (size_t j = next++; j < jobs.size() && !stop.stop_requested(); j = next++) {
      if (!workers[w]) {
        workers[w] = std::make_unique<Worker>(receiver_, method_, window.row_end - window.row_begin,
                                              plane_count);
      }
      Worker& worker = *workers[w];
      worker.shadow.Draw(*jobs[j].occluders, outlines[jobs[j].side], jobs[j].sample, jobs[j].map,
                         window, worker.bitmap);
      if (stored_in_) stored_in_->Store(jobs[j].number, window.row_begin, worker.bitmap);
      if (beyond_) beyond_->Subtract(jobs[j].number, window.row_begin, worker.bitmap);
      worker.CountBitmap();
    }
  });
  if (stop.stop_requested()) return;
  AddCounts(workers, window, counts_.data() + size_t{window.row_begin} * receiver_.width);
}

absl::Status OcclusionCounter::Add(std::span<const LightSample> samples, tbb::task_arena& arena,
                                   const std::stop_token& stop) {
  const std::vector<Job> jobs = JobsFor(samples, stop);
  const std::array<SeenOutlines, 2> outlines = OutlinesFor(jobs, arena);
  const uint32_t columns = (receiver_.width + 31) / 32;
  const uint32_t band_rows = std::clamp(kBandWords / columns, 1u, receiver_.height);
  const int worker_count = std::min(arena.max_concurrency(), static_cast<int>(jobs.size()));
  for (uint32_t row = 0; row < receiver_.height && !jobs.empty(); row += band_rows) {
    const TexelWindow window{receiver_.width, row, std::min(row + band_rows, receiver_.height)};
    RunIn(arena, [&] { AddBand(jobs, outlines, window, worker_count, stop); });
    if (stop.stop_requested()) break;
  }
  return stop.stop_requested() ? absl::CancelledError("stop requested") : absl::OkStatus();
}

}  // namespace penumbra
