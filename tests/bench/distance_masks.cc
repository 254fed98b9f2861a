#include "tests/bench/distance_masks.h"

#include <algorithm>
#include <functional>
#include <random>
#include <utility>

#include "render/light_view/raster_depth_source.h"
#include "render/light_view/view_fit.h"
#include "tests/bench/bench.h"
#include "tests/bench/studio.h"
#include "tests/support/pile_of_things.h"

namespace penumbra::bench {
namespace {

using Random = std::function<double(double, double)>;

Random Uniform() {
  return [random = std::mt19937(2003)](double from, double to) mutable {
    return std::uniform_real_distribution<double>(from, to)(random);
  };
}

void AddDisk(double x, double y, double radius, DistanceMask& mask) {
  const double last = mask.side - 1;
  const auto from = [](double value) { return static_cast<uint32_t>(std::max(0.0, value)); };
  const auto to = [&](double value) { return static_cast<uint32_t>(std::min(last, value)); };
  for (uint32_t j = from(y - radius); j <= to(y + radius); ++j) {
    for (uint32_t i = from(x - radius); i <= to(x + radius); ++i) {
      const double dx = i - x, dy = j - y;
      if (dx * dx + dy * dy <= radius * radius) mask.blocked[size_t{j} * mask.side + i] = 1;
    }
  }
}

DistanceMask Disks(std::string name, uint32_t side, size_t count, double least, double most) {
  DistanceMask mask{std::move(name), side, true, std::vector<uint8_t>(size_t{side} * side, 0)};
  const Random random = Uniform();
  for (size_t k = 0; k < count; ++k) {
    AddDisk(random(0, side), random(0, side), random(least, most), mask);
  }
  return mask;
}

DistanceMask AllBut(std::string name, uint32_t side, int count) {
  DistanceMask mask{std::move(name), side, false, std::vector<uint8_t>(size_t{side} * side, 1)};
  const Random random = Uniform();
  for (int k = 0; k < count; ++k) {
    mask.blocked[static_cast<size_t>(random(0, 1) * static_cast<double>(mask.blocked.size()))] = 0;
  }
  return mask;
}

DistanceMask Noise(uint32_t side) {
  DistanceMask mask{"noise", side, false, {}};
  const Random random = Uniform();
  for (size_t t = 0; t < size_t{side} * side; ++t) mask.blocked.push_back(random(0, 1) < 0.5);
  return mask;
}

// What the lamp's middle sees of the scene, stretched to a square.
DistanceMask Seen(std::string name, const SceneDelta& delta, uint32_t side) {
  const auto scene = Scene::Empty("bench")->Apply(delta).value();
  const LightFace face = FacesOf(*scene->FindLight("lamp"), scene->Bounds()).at(0);
  std::vector<Aabb> boxes;
  for (const auto& [id, instance] : scene->instances()) boxes.push_back(WorldBounds(*instance));
  const double size = CenterView(face, boxes, 1e-3)->window.size().x;
  const LightView view = *CenterView(face, boxes, size / side);
  DistanceMask mask{std::move(name), side, true, {}};
  tbb::task_arena arena(1);
  RasterDepthSource source(*scene, arena);
  const absl::Status drawn = source.Draw({&view, 1}, {}, [&](size_t, const DepthMap& map) {
    for (uint32_t y = 0; y < side; ++y) {
      for (uint32_t x = 0; x < side; ++x) {
        const float depth = map.At(x * view.width / side, y * view.height / side);
        mask.blocked.push_back(depth != kNoDepth);
      }
    }
    return absl::OkStatus();
  });
  if (!drawn.ok()) OrDie<int>(drawn);
  return mask;
}

}  // namespace

std::vector<DistanceMask> DistanceMasks(uint32_t side) {
  SceneDelta pile = Studio(1);
  pile.upsert_instances = testing::PileOfThings();
  return {Seen("boxes", Boxes(84, 1), side),
          Seen("pile", pile, side),
          Disks("blobs", side, size_t{side} * side / 400, 1, 12),
          Disks("disks", side, 5, 0.1 * side, 0.25 * side),
          Noise(side),
          AllBut("dots", side, 64),
          AllBut("all_but_one", side, 1)};
}

}  // namespace penumbra::bench
