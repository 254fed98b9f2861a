// What penumbra_bench's suites share.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"

namespace penumbra::bench {

struct Row {
  std::string metric;  // suite.case.quantity
  double value = 0;
  std::string unit;
};

struct BenchOptions {
  int threads = 2;           // for us and for the peer
  double min_seconds = 2.0;  // that a case measures for, both sides together
  std::string ply;           // a mesh for cases that take one; empty: a generated one
  std::string pictures;      // a folder for pictures of where errors are; empty: none are written
};

using Suite = std::vector<Row> (*)(const BenchOptions&);

std::vector<Row> SoftTextureSuite(const BenchOptions& options);
// Parts of soft_texture that can be asked for alone.
std::vector<Row> SilhouetteSuite(const BenchOptions& options);
std::vector<Row> MethodsSuite(const BenchOptions& options);
std::vector<Row> GrowthSuite(const BenchOptions& options);
std::vector<Row> RadianceSuite(const BenchOptions& options);
std::vector<Row> ServiceSuite(const BenchOptions& options);
std::vector<Row> QueueSuite(const BenchOptions& options);
std::vector<Row> CoherentRaytraceSuite(const BenchOptions& options);
std::vector<Row> GlSuite(const BenchOptions& options);
std::vector<Row> LightViewSuite(const BenchOptions& options);
std::vector<Row> ShadowVolumeSuite(const BenchOptions& options);

std::vector<Row> ShadowWidthSuite(const BenchOptions& options);
// Its distance transforms alone.
std::vector<Row> DistanceSuite(const BenchOptions& options);

std::vector<Row> LayeredAttenuationSuite(const BenchOptions& options);

// Many clients on one scene; a part of ServiceSuite.
std::vector<Row> SharedSceneRows();

// What tells how soon shadows follow a drag; a part of SoftTextureSuite.
std::vector<Row> DragRows(const BenchOptions& options);

// A benchmark that cannot do what it measures ends with the reason.
template <typename T>
T OrDie(absl::StatusOr<T> result) {
  if (result.ok()) return *std::move(result);
  std::fprintf(stderr, "penumbra_bench: %s\n", std::string(result.status().message()).c_str());
  std::exit(EXIT_FAILURE);
}

inline double NowMs() {
  return std::chrono::duration<double, std::milli>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

inline double Percentile(std::vector<double> values, double fraction) {
  if (values.empty()) return 0;
  const auto rank = static_cast<size_t>(fraction * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(rank),
                   values.end());
  return values[rank];
}

inline double Median(std::vector<double> values) { return Percentile(std::move(values), 0.5); }

// Wall times of two rivals in milliseconds, measured in turn so that what disturbs the machine
// disturbs both.
struct Duel {
  std::vector<double> ours_ms, peers_ms;

  double OursMs() const { return Median(ours_ms); }
  double PeersMs() const { return Median(peers_ms); }
  double Speedup() const { return PeersMs() / OursMs(); }
};

// Runs each once to warm up, then both in turn until `min_seconds` have passed and each has run
// five times.
Duel Interleave(double min_seconds, const std::function<void()>& ours,
                const std::function<void()>& peers);

}  // namespace penumbra::bench
