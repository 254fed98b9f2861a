// Distance transforms of shadow_width. The peer of the exact one is OpenCV's precise one on as many
// threads; both write over the same memory each time. A row speedup_vs_opencv is the least of all
// masks. The paper's approximations are held against the exact one: how far they are off where
// texels are blocked, on all masks of shadows together, how many of those they reach from no lit
// texel, and how long they take.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <string>
#include <utility>

#include "render/gl/context.h"
#include "render/technique/shadow_width/distance_exact.h"
#include "render/technique/shadow_width/distance_sweep.h"
#include "render/technique/shadow_width/gl/distance_steps.h"
#include "tests/bench/bench.h"
#include "tests/bench/distance_masks.h"

namespace penumbra::bench {
namespace {

constexpr uint32_t kSides[] = {256, 512, 1024, 2048};
constexpr uint32_t kErrorSide = 512;

// Of BenchOptions::min_seconds, for each mask, size and number of threads.
constexpr double kShareOfTime = 0.1;

using Transform = std::function<std::vector<float>(const BlockedMask&)>;

double LargestDifference(const std::vector<float>& ours, const cv::Mat& peers) {
  double most = 0;
  for (size_t t = 0; t < ours.size(); ++t) {
    most = std::max(most, std::abs(double{ours[t]} - peers.ptr<float>()[t]));
  }
  return most;
}

void AddSpeed(const std::string& prefix, const std::vector<DistanceMask>& masks, int threads,
              const BenchOptions& options, std::vector<Row>& rows) {
  tbb::task_arena arena(threads);
  cv::setNumThreads(threads);
  const int side = static_cast<int>(masks[0].side);
  double least = std::numeric_limits<double>::infinity(), difference = 0;
  for (const DistanceMask& mask : masks) {
    std::vector<uint8_t> pixels = mask.blocked;
    const cv::Mat image(side, side, CV_8U, pixels.data());
    cv::Mat peers;
    std::vector<float> ours;
    const Duel duel = Interleave(
        kShareOfTime * options.min_seconds,
        [&] { ours = OrDie(DistanceToLit(mask.View(), arena, {}, std::move(ours))); },
        [&] { cv::distanceTransform(image, peers, cv::DIST_L2, cv::DIST_MASK_PRECISE); });
    rows.push_back({prefix + mask.name + ".median", duel.OursMs(), "ms"});
    rows.push_back({prefix + mask.name + ".speedup_vs_opencv", duel.Speedup(), "x"});
    least = std::min(least, duel.Speedup());
    difference = std::max(difference, LargestDifference(ours, peers));
  }
  rows.push_back({prefix + "speedup_vs_opencv", least, "x"});
  rows.push_back({prefix + "largest_difference_vs_opencv", difference, "texels"});
}

// How far an approximation is off the exact transform where texels are blocked.
struct ErrorSums {
  double sum = 0, most = 0, relative_sum = 0, relative_most = 0;
  size_t reached = 0, unreached = 0;

  void Add(float distance, float exact) {
    if (exact == 0) return;
    if (std::isinf(distance)) {
      ++unreached;
      return;
    }
    const double error = std::abs(double{distance} - exact);
    ++reached;
    sum += error;
    most = std::max(most, error);
    relative_sum += error / exact;
    relative_most = std::max(relative_most, error / exact);
  }
};

void AddErrors(const std::string& name, const std::vector<DistanceMask>& masks,
               const Transform& transform, const Transform& exact, double seconds,
               std::vector<Row>& rows) {
  ErrorSums errors;
  std::vector<double> exact_ms, ms;
  for (const DistanceMask& mask : masks) {
    const std::vector<float> found = transform(mask.View()), truth = exact(mask.View());
    for (size_t t = 0; t < truth.size(); ++t) errors.Add(found[t], truth[t]);
    const Duel duel = Interleave(
        seconds, [&] { (void)transform(mask.View()); }, [&] { (void)exact(mask.View()); });
    ms.push_back(duel.OursMs());
    exact_ms.push_back(duel.PeersMs());
  }
  const auto reached = static_cast<double>(errors.reached);
  const auto unreached = static_cast<double>(errors.unreached);
  rows.insert(rows.end(), {{name + "_error_mean", errors.sum / reached, "texels"},
                           {name + "_error_max", errors.most, "texels"},
                           {name + "_relative_error_mean", errors.relative_sum / reached, "1"},
                           {name + "_relative_error_max", errors.relative_most, "1"},
                           {name + "_unreached", unreached / (reached + unreached), "1"},
                           {name + "_median", Median(ms), "ms"},
                           {name + "_speedup_vs_exact", Median(exact_ms) / Median(ms), "x"}});
}

void AddAllErrors(const BenchOptions& options, std::vector<Row>& rows) {
  std::vector<DistanceMask> masks = DistanceMasks(kErrorSide);
  std::erase_if(masks, [](const DistanceMask& mask) { return !mask.is_of_shadows; });
  const std::string prefix = "shadow_width.w" + std::to_string(kErrorSide) + ".";
  const double seconds = kShareOfTime * options.min_seconds;
  tbb::task_arena arena(options.threads);
  const Transform exact = [&](const BlockedMask& mask) {
    return OrDie(DistanceToLit(mask, arena, {}));
  };
  const auto add = [&](const char* name, const Transform& transform) {
    AddErrors(prefix + name, masks, transform, exact, seconds, rows);
  };
  const auto sweeps = [&](SweepNeighbours neighbours) {
    return [&arena, neighbours](const BlockedMask& mask) {
      return OrDie(DistanceBySweeps(mask, neighbours, arena, {}));
    };
  };
  add("sweep", sweeps(SweepNeighbours::kFour));
  add("sweep8", sweeps(SweepNeighbours::kEight));
  const auto context = gl::Context::Create();
  if (!context.ok()) {
    std::fprintf(stderr, "shadow_width: gl is left out, %s\n",
                 std::string(context.status().message()).c_str());
    return;
  }
  std::fprintf(stderr, "shadow_width: gl is %s\n", (*context)->info().renderer.c_str());
  const auto steps = [&](StepNeighbours neighbours) {
    return [&context, neighbours](const BlockedMask& mask) {
      return OrDie(DistanceBySteps(**context, mask, neighbours, {}));
    };
  };
  add("gpu3", steps(StepNeighbours::kThree));
  add("gpu6", steps(StepNeighbours::kSix));
}

}  // namespace

std::vector<Row> DistanceSuite(const BenchOptions& options) {
  std::vector<Row> rows;
  for (const uint32_t side : kSides) {
    const std::vector<DistanceMask> masks = DistanceMasks(side);
    const std::string prefix = "shadow_width.w" + std::to_string(side) + ".";
    AddSpeed(prefix, masks, options.threads, options, rows);
    if (options.threads > 1) AddSpeed(prefix + "one_thread.", masks, 1, options, rows);
  }
  AddAllErrors(options, rows);
  return rows;
}

}  // namespace penumbra::bench
