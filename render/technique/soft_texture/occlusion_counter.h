// Counts, for each texel of a receiver, the light samples that occluders hide from it.
//
//   OcclusionCounter counter(scene, receiver, surface_offset);
//   if (auto status = counter.Add(samples, arena, stop); !status.ok()) return status;
//   counter.counts()
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <stop_token>
#include <vector>

#include "absl/status/status.h"
#include "render/scene/light_sample.h"
#include "render/scene/receiver.h"
#include "render/scene/scene.h"
#include "render/technique/soft_texture/coverage_kernel.h"
#include "render/technique/soft_texture/occluder_set.h"
#include "render/technique/soft_texture/receiver_transform.h"
#include "tbb/task_arena.h"

namespace penumbra {

class OcclusionCounter {
 public:
  // Occluders within `surface_offset` metres of the receiver's plane do not count, nor does a
  // sample that is as near to it: it hides from nothing and sheds no light.
  OcclusionCounter(const Scene& scene, const ReceiverPatch& receiver, double surface_offset);

  // Adds what hides `samples`. The result depends on neither the arena's size nor how samples are
  // split into calls.
  //
  // Errors  kCancelled: stop requested, asked once a sample; the counts are then of no use
  // Cost    O(samples · (triangles + texels drawn / 32))
  absl::Status Add(std::span<const LightSample> samples, tbb::task_arena& arena,
                   const std::stop_token& stop);

  // H·W, row by row.
  const std::vector<uint16_t>& counts() const { return counts_; }

 private:
  // A sample's map, and the occluders on its side of the receiver.
  struct Job {
    ReceiverTransform map;
    const OccluderSet* occluders;
  };

  const OccluderSet& OccludersOn(int side);
  std::vector<Job> JobsFor(std::span<const LightSample> samples);
  // Adds all jobs to the counts of the window's rows; leaves them as they are once stopped.
  void AddBand(const std::vector<Job>& jobs, const TexelWindow& window, int worker_count,
               const std::stop_token& stop);

  const Scene& scene_;
  ReceiverPatch receiver_;
  double surface_offset_;
  std::array<std::unique_ptr<OccluderSet>, 2>
      occluders_;  // on the front, on the back; made on first use
  std::vector<uint16_t> counts_;
};

}  // namespace penumbra
