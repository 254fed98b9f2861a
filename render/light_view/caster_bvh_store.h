// What CasterBvhs finds again: the hierarchies of one scene as it changes, shared by all who trace
// its rays.
//
//   auto store = std::make_shared<CasterBvhStore>(&budget);
//   CasterBvhs(stop, store).Of(scene);
#pragma once

#include <array>
#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <stop_token>

#include "render/light_view/caster_bvh.h"
#include "render/light_view/kept_slot.h"
#include "render/math/memory_budget.h"
#include "render/scene/scene.h"

struct RTCDeviceTy;

namespace penumbra {

class PlacedTriangles;

// Of the scene that was asked for last everything is kept, as far as the budget goes: instances'
// triangles, the hierarchies over each and those over all. Any thread may ask; one builds at a
// time.
class CasterBvhStore {
 public:
  // `budget`  outlives the store; null: what nobody uses is not kept
  explicit CasterBvhStore(MemoryBudget* budget);
  ~CasterBvhStore();

  // See CasterBvhs.
  std::shared_ptr<const CasterBvh> Of(const Scene& scene, CasterBvhs::Instances which,
                                      const std::stop_token& stop);
  std::shared_ptr<const CasterBvh> Flat(const Scene& scene, const std::stop_token& stop);
  size_t built() const { return built_; }

 private:
  struct Tree;
  class Turn;
  class Build;
  template <typename T>
  using ByInstance = std::map<const Instance*, KeptSlot<T>>;
  struct Newest {
    std::weak_ptr<const Scene::Table<Instance>> table;
    KeptSlot<CasterBvh> bvh;

    std::shared_ptr<const CasterBvh> Find(const Scene& scene) const;
  };

  // What `scene` does not have is kept no longer.
  void KeepOnlyWhatIsIn(const Scene& scene);

  const std::shared_ptr<RTCDeviceTy> device_;
  MemoryBudget* const budget_;
  std::atomic<size_t> built_ = 0;

  std::mutex mutex_;
  std::condition_variable_any is_free_;
  bool is_taken_ = false;  // by one who builds; what follows is his
  ByInstance<PlacedTriangles> triangles_;
  ByInstance<Tree> trees_;
  std::array<Newest, 2> newest_;  // of each choice
  Newest newest_flat_;
};

}  // namespace penumbra
