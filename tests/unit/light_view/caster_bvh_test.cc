// What is built, what is found again, what is kept and what a stop ends.
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <stop_token>
#include <thread>
#include <utility>

#include "render/light_view/caster_bvh_store.h"
#include "tests/support/random_scene.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {
namespace {

// Three boxes, the first of which stands at `x`.
SceneDelta Boxes(float x = 0) {
  static const auto box = MeshOf(UnitBoxGeometry());
  SceneDelta delta;
  for (const char* id : {"a", "b", "c"}) {
    delta.upsert_instances.push_back(
        {.id = id, .mesh = box, .world_from_mesh = Placed(Vec3(x, 0, 0), 0.1f)});
    x = 1.0f;
  }
  return delta;
}

std::shared_ptr<const Scene> WithBoxes(const SceneDelta& delta) {
  return Scene::Empty("s")->Apply(delta).value();
}

SceneDelta FirstBoxAt(float x) { return {.upsert_instances = {Boxes(x).upsert_instances[0]}}; }

// n by n squares, not quite flat.
std::shared_ptr<const Scene> Grid(uint32_t n) {
  MeshGeometry grid;
  for (uint32_t j = 0; j <= n; ++j) {
    for (uint32_t i = 0; i <= n; ++i) {
      grid.positions.emplace_back(i, (i * j) % 7, j);
    }
  }
  for (uint32_t j = 0; j < n; ++j) {
    for (uint32_t i = 0; i < n; ++i) {
      const uint32_t k = j * (n + 1) + i;
      for (const uint32_t corner : {k, k + 1, k + n + 1, k + 1, k + n + 2, k + n + 1}) {
        grid.indices.push_back(corner);
      }
    }
  }
  return WithBoxes({.upsert_instances = {{.id = "grid", .mesh = MeshOf(std::move(grid))}}});
}

TEST(CasterBvhsTest, BuildsAMeshOnceAndNothingForAnotherLight) {
  CasterBvhs bvhs;
  const auto scene = RandomScene(3);
  const auto first = bvhs.Of(*scene);
  SceneDelta delta;
  delta.upsert_lights = {{.id = "another", .shape = PointLight{}}};
  EXPECT_EQ(bvhs.Of(*scene->Apply(delta).value()), first);
}

TEST(CasterBvhsTest, OneForAllTrianglesTakesNoneForEachInstance) {
  CasterBvhs bvhs;
  const auto flat = bvhs.Flat(*WithBoxes(Boxes()));
  ASSERT_TRUE(flat->status().ok()) << flat->status();
  EXPECT_EQ(flat->triangle_count(), 36u);
  EXPECT_EQ(bvhs.built(), 1u);
}

TEST(CasterBvhStoreTest, WhatAnEditLeavesIsKeptThoughNobodyUsesIt) {
  MemoryBudget budget(1 << 20);
  const CasterBvhs bvhs({}, std::make_shared<CasterBvhStore>(&budget));
  const auto before = WithBoxes(Boxes());
  bvhs.Of(*before);
  bvhs.Of(*before, CasterBvhs::Instances::kAll);
  bvhs.Flat(*before);
  EXPECT_EQ(bvhs.built(), 4u);
  bvhs.Of(*before);
  bvhs.Flat(*before);
  EXPECT_EQ(bvhs.built(), 4u);
  const auto after = before->Apply(FirstBoxAt(0.5f)).value();
  bvhs.Of(*after);
  EXPECT_EQ(bvhs.built(), 5u) << "the box that moved";
  bvhs.Flat(*after);
  EXPECT_EQ(bvhs.built(), 6u);
}

TEST(CasterBvhStoreTest, WithoutRoomNothingIsKept) {
  MemoryBudget none(100);
  const CasterBvhs bvhs({}, std::make_shared<CasterBvhStore>(&none));
  const auto scene = WithBoxes(Boxes());
  EXPECT_TRUE(bvhs.Of(*scene)->status().ok());
  EXPECT_TRUE(bvhs.Of(*scene)->status().ok());
  EXPECT_EQ(bvhs.built(), 6u);
  const auto used = bvhs.Of(*scene);
  EXPECT_EQ(bvhs.Of(*scene), used);
}

TEST(CasterBvhStoreTest, RoomComesBackWithWhatGoes) {
  constexpr size_t kAll = 1 << 20;
  MemoryBudget budget(kAll);
  auto store = std::make_shared<CasterBvhStore>(&budget);
  const auto scene = WithBoxes(Boxes());
  CasterBvhs({}, store).Of(*scene);
  CasterBvhs({}, store).Flat(*scene);
  EXPECT_FALSE(budget.Take(kAll));
  // An edit that leaves nothing.
  CasterBvhs({}, store).Of(*scene->Apply({.remove_instances = {"a", "b", "c"}}).value());
  EXPECT_TRUE(budget.Take(kAll));
  CasterBvhs({}, store).Of(*scene);
  EXPECT_FALSE(budget.Take(kAll));
  store.reset();
  EXPECT_TRUE(budget.Take(kAll));
}

TEST(CasterBvhsTest, OfWhatWasStoppedStatusSaysSo) {
  std::stop_source stop;
  const auto store = std::make_shared<CasterBvhStore>(nullptr);
  const CasterBvhs stopped(stop.get_token(), store);
  const auto scene = WithBoxes(Boxes());
  stop.request_stop();
  EXPECT_EQ(stopped.Of(*scene)->status().code(), absl::StatusCode::kCancelled);
  EXPECT_EQ(stopped.Flat(*scene)->status().code(), absl::StatusCode::kCancelled);
  EXPECT_EQ(stopped.Flat(*scene)->embree(), nullptr);
  // Nothing of it is found by others.
  EXPECT_TRUE(CasterBvhs({}, store).Of(*scene)->status().ok());
  EXPECT_TRUE(CasterBvhs({}, store).Flat(*scene)->status().ok());
}

double Milliseconds(std::chrono::steady_clock::time_point since) {
  const std::chrono::duration<double, std::milli> passed = std::chrono::steady_clock::now() - since;
  return passed.count();
}

// How long `ask` takes, of bvhs that are stopped after `stop_ms`.
template <typename Ask>
double TimeOf(const Ask& ask, double stop_ms) {
  std::stop_source stop;
  const CasterBvhs bvhs(stop.get_token());
  const auto start = std::chrono::steady_clock::now();
  const std::jthread stopper([&](const std::stop_token& over) {
    while (!over.stop_requested() && Milliseconds(start) < stop_ms) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    if (!over.stop_requested()) stop.request_stop();
  });
  const absl::Status status = ask(bvhs)->status();
  const double ms = Milliseconds(start);
  EXPECT_EQ(absl::IsCancelled(status), stop.stop_requested()) << status;
  return ms;
}

// Three times, for other programs take turns with this one.
TEST(CasterBvhsTest, AStopEndsABuildOnItsWay) {
  const auto grid = Grid(600);
  const auto of = [&](const CasterBvhs& bvhs) { return bvhs.Of(*grid); };
  const auto flat = [&](const CasterBvhs& bvhs) { return bvhs.Flat(*grid); };
  const auto is_ended = [](const auto& ask) {
    const double whole_ms = TimeOf(ask, 1e9);
    return TimeOf(ask, 0.3 * whole_ms) < 0.7 * whole_ms;
  };
  EXPECT_TRUE(is_ended(of) || is_ended(of) || is_ended(of));
  EXPECT_TRUE(is_ended(flat) || is_ended(flat) || is_ended(flat));
}

TEST(CasterBvhStoreTest, AStopEndsTheWaitForSomebodyElsesBuild) {
  const auto grid = Grid(600);
  const auto store = std::make_shared<CasterBvhStore>(nullptr);
  std::stop_source stop;
  std::shared_ptr<const CasterBvh> whole, stopped;
  {
    const std::jthread builder([&] { whole = CasterBvhs({}, store).Of(*grid); });
    while (store->built() == 0) std::this_thread::yield();
    const std::jthread waiter([&] { stopped = CasterBvhs(stop.get_token(), store).Of(*grid); });
    stop.request_stop();
  }
  EXPECT_TRUE(whole->status().ok()) << whole->status();
  EXPECT_TRUE(absl::IsCancelled(stopped->status())) << stopped->status();
}

}  // namespace
}  // namespace penumbra::testing
