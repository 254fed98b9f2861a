// Attenuation LDIs of 512 pixels on four scenes that lie where PENUMBRA_SCENES says, each on a
// floor under a lamp: how far off they are at a camera's 512×512 visible points, how long they
// take, how many layers they have. The peer is Embree tracing packets of 16 rays from the LDI's own
// layers to the same samples, which gives what the LDI holds. Neither's hierarchy over triangles is
// in its time.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>

#include "client/display/image_io.h"
#include "client/import/import_scene.h"
#include "tests/bench/bench.h"
#include "tests/bench/display_rows.h"
#include "tests/support/ldi_study.h"
#include "tests/support/scenes_folder.h"

namespace penumbra::bench {
namespace {

using testing::LdiError;
using testing::LdiStudy;

struct NamedScene {
  const char* name;
  const char* path;
};

constexpr NamedScene kScenes[] = {
    {"dragon", "stanford-dragon-res2/dragon_vrip_res2.ply"},
    {"garden", "bridge-garden/scene.glb"},
    {"flower", "flower/flower_blue.glb"},
    {"plants", "plants-unclear-licence/plants.gltf"},
};

// What rays tell, what the LDI tells, and the difference: grey is none, red too light, blue too
// dark, in full colour at half of the light.
void WritePicture(const std::filesystem::path& path, const testing::CameraPoints& seen,
                  const LdiError& error) {
  const uint32_t width = 3 * seen.width;
  std::vector<uint8_t> rgb(size_t{3} * width * seen.height, 40);
  const auto put = [&](size_t i, uint32_t part, float r, float g, float b) {
    const size_t place = i / seen.width * width + part * seen.width + i % seen.width;
    const float channels[] = {r, g, b};
    for (int c = 0; c < 3; ++c) {
      rgb[3 * place + c] = static_cast<uint8_t>(std::clamp(255 * channels[c], 0.0f, 255.0f));
    }
  };
  for (size_t i = 0; i < seen.points.size(); ++i) {
    if (!seen.is_hit[i]) continue;
    const float traced = error.traced[i], found = error.found[i], off = found - traced;
    put(i, 0, traced, traced, traced);
    put(i, 1, found, found, found);
    put(i, 2, 0.5f + off, 0.5f - std::abs(off), 0.5f - off);
  }
  const absl::Status status = WritePng(path.string(), width, seen.height, rgb);
  if (!status.ok()) {
    std::fprintf(stderr, "penumbra_bench: %s\n", std::string(status.message()).c_str());
    std::exit(EXIT_FAILURE);
  }
}

std::vector<Row> RunErrors(const std::string& name, LdiStudy& study, const BenchOptions& options) {
  std::vector<Row> rows;
  for (const bool key_views : {false, true}) {
    for (const uint32_t samples : {64u, 256u}) {
      const LdiOptions ldi_options{.samples = samples, .key_views = key_views};
      const LdiError error = study.Compare(study.Build(ldi_options), ldi_options);
      const std::string suffix =
          (key_views ? "_by_key_views" : "") + std::string(samples == 64 ? "" : "_256");
      rows.push_back({name + ".mean_abs_error" + suffix, error.mean, "1"});
      rows.push_back({name + ".p99_abs_error" + suffix, error.p99, "1"});
      rows.push_back({name + ".bias" + suffix, error.bias, "1"});
      if (options.pictures.empty()) continue;
      WritePicture(std::filesystem::path(options.pictures) / (name + "_ldi" + suffix + ".png"),
                   study.camera_points(), error);
    }
  }
  return rows;
}

std::vector<Row> RunLayers(const std::string& name, LdiStudy& study) {
  std::vector<Row> rows;
  double at_4 = 1, at_256 = 0;
  for (const uint32_t samples : {1u, 4u, 16u, 64u, 256u}) {
    const double layers = testing::MeanLayers(study.Build({.samples = samples}));
    if (samples == 4) at_4 = layers;
    at_256 = layers;
    rows.push_back({name + ".layers_" + std::to_string(samples), layers, "1"});
  }
  rows.push_back({name + ".layers_256_over_4", at_256 / at_4, "1"});
  return rows;
}

std::vector<Row> RunSpeed(const std::string& name, LdiStudy& study, const BenchOptions& options) {
  const AttenuationLdi ldi = study.Build({});
  const Duel duel = Interleave(
      0.25 * options.min_seconds, [&] { (void)study.Build({}); },
      [&] { (void)study.TraceFromLayers(ldi, {}); });
  const Duel keys = Interleave(
      0.1 * options.min_seconds, [&] { (void)study.Build({.key_views = true}); },
      [&] { (void)study.Build({}); });
  return {{name + ".triangles", static_cast<double>(study.triangle_count()), "1"},
          {name + ".build", duel.OursMs(), "ms"},
          {name + ".build_speedup_vs_embree", duel.Speedup(), "x"},
          {name + ".key_views_speedup_vs_drawing", keys.Speedup(), "x"},
          {name + ".is_drawn_by_rays", static_cast<double>(study.is_drawn_by_rays()), "1"}};
}

std::vector<Row> RunGrowth(const ImportedScene& imported, LdiStudy& study,
                           const BenchOptions& options) {
  LdiStudy fine(testing::OnAFloor(testing::Subdivided(imported.instances)), options.threads);
  const Duel duel = Interleave(
      options.min_seconds, [&] { (void)fine.Build({}); }, [&] { (void)study.Build({}); });
  return {{"growth_10x_triangles", duel.OursMs() / duel.PeersMs(), "x"},
          {"growth_10x_is_drawn_by_rays", static_cast<double>(fine.is_drawn_by_rays()), "1"}};
}

}  // namespace

std::vector<Row> LayeredAttenuationSuite(const BenchOptions& options) {
  std::vector<Row> rows;
  const auto add = [&rows](std::vector<Row> more) {
    rows.insert(rows.end(), more.begin(), more.end());
  };
  for (const auto& [name, path] : kScenes) {
    const auto imported = ImportScene(testing::ScenesFolder(PENUMBRA_DEFAULT_SCENES) / path);
    if (!imported.ok()) {
      std::fprintf(stderr, "penumbra_bench: layered_attenuation leaves %s out: %s\n", name,
                   std::string(imported.status().message()).c_str());
      continue;
    }
    LdiStudy study(testing::OnAFloor(imported->instances), options.threads);
    add(RunSpeed(name, study, options));
    add(RunErrors(name, study, options));
    add(RunLayers(name, study));
    add(DisplayRows(name, study.scene(), study.Build({}), options));
    if (std::string(name) == "dragon") add(RunGrowth(*imported, study, options));
  }
  return rows;
}

}  // namespace penumbra::bench
