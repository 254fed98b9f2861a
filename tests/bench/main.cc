// penumbra_bench: how fast Penumbra is, as ratios against peers measured in the same run.
//
// Absolute times say little: machines differ, and their neighbours disturb them. So each case runs
// us and a peer in turn on as many threads and reports medians and their ratio. A ratio is named
// speedup_vs_PEER (larger is better) or overhead_vs_PEER (smaller is better).

#include <tbb/global_control.h>

#include <cstdio>
#include <fstream>
#include <iterator>

#include "CLI/CLI.hpp"
#include "nlohmann/json.hpp"
#include "server/keep_freed_memory.h"
#include "tests/bench/bench.h"

namespace penumbra::bench {
namespace {

struct NamedSuite {
  const char* name;
  Suite run;
  bool is_part = false;  // of another: not run unless it is named
};

constexpr NamedSuite kSuites[] = {{"soft_texture", SoftTextureSuite},
                                  {"silhouette", SilhouetteSuite, true},
                                  {"methods", MethodsSuite, true},
                                  {"growth", GrowthSuite, true},
                                  {"radiance", RadianceSuite},
                                  {"layered_attenuation", LayeredAttenuationSuite},
                                  {"shadow_width", ShadowWidthSuite},
                                  {"distance", DistanceSuite, true},
                                  {"coherent_raytrace", CoherentRaytraceSuite},
                                  {"shadow_volume", ShadowVolumeSuite},
                                  {"service", ServiceSuite},
                                  {"queue", QueueSuite},
                                  {"gl", GlSuite},
                                  {"light_view", LightViewSuite}};

void Print(const std::vector<Row>& rows) {
  for (const Row& row : rows) {
    std::printf("%-52s %14.6g %s\n", row.metric.c_str(), row.value, row.unit.c_str());
  }
}

bool WriteJson(const std::string& path, const std::vector<Row>& rows) {
  nlohmann::json json = nlohmann::json::array();
  for (const Row& row : rows) {
    json.push_back({{"metric", row.metric}, {"value", row.value}, {"unit", row.unit}});
  }
  std::ofstream file(path);
  file << json.dump(2) << '\n';
  return static_cast<bool>(file.flush());
}

}  // namespace

Duel Interleave(double min_seconds, const std::function<void()>& ours,
                const std::function<void()>& peers) {
  constexpr size_t kLeastRuns = 5;
  ours();
  peers();
  Duel duel;
  const double end = NowMs() + 1000 * min_seconds;
  while (NowMs() < end || duel.ours_ms.size() < kLeastRuns) {
    const double start = NowMs();
    ours();
    const double middle = NowMs();
    peers();
    duel.ours_ms.push_back(middle - start);
    duel.peers_ms.push_back(NowMs() - middle);
  }
  return duel;
}

int Main(int argc, char** argv) {
  CLI::App app{"Measures Penumbra against its peers."};
  std::vector<std::string> wanted;
  std::string json_path;
  BenchOptions options;
  std::vector<std::string> names;
  for (const NamedSuite& suite : kSuites) names.emplace_back(suite.name);
  app.add_option("--suite", wanted, "Suites to run; all if none is named")
      ->check(CLI::IsMember(names));
  app.add_option("--json", json_path, "Also write the rows to this file");
  app.add_option("--threads", options.threads, "Threads for us and for the peer")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  app.add_option("--seconds", options.min_seconds, "Least time to spend on a case")
      ->check(CLI::Range(0.0, 600.0))
      ->capture_default_str();
  app.add_option("--ply", options.ply, "Mesh for soft_texture.dragon; a generated one if absent");
  app.add_option("--pictures", options.pictures,
                 "Folder for pictures of where layered_attenuation is off; none if absent");
  CLI11_PARSE(app, argc, argv);

  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism,
                                    static_cast<size_t>(options.threads));
  std::vector<Row> all;
  for (const NamedSuite& suite : kSuites) {
    const bool is_named = std::find(wanted.begin(), wanted.end(), suite.name) != wanted.end();
    if (wanted.empty() ? suite.is_part : !is_named) continue;
    std::vector<Row> rows = suite.run(options);
    Print(rows);
    std::move(rows.begin(), rows.end(), std::back_inserter(all));
  }
  if (!json_path.empty() && !WriteJson(json_path, all)) {
    std::fprintf(stderr, "penumbra_bench: --json: cannot write %s\n", json_path.c_str());
    return 1;
  }
  return 0;
}

}  // namespace penumbra::bench

int main(int argc, char** argv) {
  penumbra::KeepFreedMemory();  // as the server does
  return penumbra::bench::Main(argc, argv);
}
