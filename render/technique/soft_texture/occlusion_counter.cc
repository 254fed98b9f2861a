#include "render/technique/soft_texture/occlusion_counter.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <optional>

#include "render/math/parallel_for.h"
#include "render/technique/soft_texture/bit_counters.h"
#include "render/technique/soft_texture/hard_shadow.h"

namespace penumbra {
namespace {

// A band's bitmap should stay in a core's second-level cache together with its counters.
constexpr uint32_t kBandWords = 1u << 16;

// One thread's share: a bitmap for the sample at hand, and the counters of all its samples.
struct Worker {
  Worker(const ReceiverPatch& receiver, uint32_t rows, uint32_t plane_count)
      : shadow(receiver), bitmap(receiver.width, rows), planes(plane_count) {
    for (auto& plane : planes) plane.resize(bitmap.words.size());
  }

  HardShadow shadow;
  ShadowBitmap bitmap;
  std::vector<std::vector<uint32_t>> planes;
};

void AddCounts(std::span<const std::unique_ptr<Worker>> workers, const TexelWindow& window,
               uint16_t* counts) {
  constexpr uint32_t kRowsPerTask = 64;
  const uint32_t rows = window.row_end - window.row_begin;
  ParallelFor((rows + kRowsPerTask - 1) / kRowsPerTask, [&](uint32_t task) {
    const uint32_t end = std::min(rows, (task + 1) * kRowsPerTask);
    for (uint32_t row = task * kRowsPerTask; row < end; ++row) {
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
                                   double surface_offset)
    : scene_(scene),
      receiver_(receiver),
      surface_offset_(surface_offset),
      counts_(size_t{receiver.width} * receiver.height, uint16_t{0}) {}

const OccluderSet& OcclusionCounter::OccludersOn(int side) {
  auto& set = occluders_[side > 0 ? 0 : 1];
  if (!set) {
    set = std::make_unique<OccluderSet>(
        PrepareOccluders(scene_, receiver_.patch, side, surface_offset_));
  }
  return *set;
}

std::vector<OcclusionCounter::Job> OcclusionCounter::JobsFor(std::span<const LightSample> samples) {
  std::vector<Job> jobs;
  for (const LightSample& sample : samples) {
    const auto map = ReceiverTransform::Create(receiver_.patch, sample, surface_offset_);
    if (!map) continue;
    const OccluderSet& occluders = OccludersOn(map->sample_height() > 0 ? 1 : -1);
    if (!occluders.groups.empty()) jobs.push_back({*map, &occluders});
  }
  return jobs;
}

void OcclusionCounter::AddBand(const std::vector<Job>& jobs, const TexelWindow& window,
                               int worker_count, const std::stop_token& stop) {
  const auto plane_count = static_cast<uint32_t>(std::bit_width(jobs.size()));
  std::vector<std::unique_ptr<Worker>> workers(worker_count);
  std::atomic<size_t> next{0};
  ParallelFor(worker_count, [&](int w) {
    for (size_t j = next++; j < jobs.size() && !stop.stop_requested(); j = next++) {
      if (!workers[w]) {
        workers[w] =
            std::make_unique<Worker>(receiver_, window.row_end - window.row_begin, plane_count);
      }
      Worker& worker = *workers[w];
      worker.shadow.Draw(*jobs[j].occluders, jobs[j].map, window, worker.bitmap);
      AddAndClear(worker.bitmap, worker.planes);
    }
  });
  if (stop.stop_requested()) return;
  AddCounts(workers, window, counts_.data() + size_t{window.row_begin} * receiver_.width);
}

absl::Status OcclusionCounter::Add(std::span<const LightSample> samples, tbb::task_arena& arena,
                                   const std::stop_token& stop) {
  const std::vector<Job> jobs = JobsFor(samples);
  const uint32_t columns = (receiver_.width + 31) / 32;
  const uint32_t band_rows = std::clamp(kBandWords / columns, 1u, receiver_.height);
  const int worker_count = std::min(arena.max_concurrency(), static_cast<int>(jobs.size()));
  for (uint32_t row = 0; row < receiver_.height && !jobs.empty(); row += band_rows) {
    const TexelWindow window{receiver_.width, row, std::min(row + band_rows, receiver_.height)};
    RunIn(arena, [&] { AddBand(jobs, window, worker_count, stop); });
    if (stop.stop_requested()) break;
  }
  return stop.stop_requested() ? absl::CancelledError("stop requested") : absl::OkStatus();
}

}  // namespace penumbra
