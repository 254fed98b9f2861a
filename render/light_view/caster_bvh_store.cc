#include "render/light_view/caster_bvh_store.h"

#include <embree3/rtcore.h>

#include <set>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "render/light_view/placed_triangles.h"
#include "render/math/hand_over.h"

namespace penumbra {
namespace {

// Of one of Embree's hierarchies, a triangle: 54 to 60 were found over 0.2 to 16 million triangles
// of regular and of ragged grids, 75 over 200.
constexpr size_t kTreeBytes = 64;
// Of one over instances, an instance.
constexpr size_t kInstanceBytes = 512;

constexpr int kTracedAsAWhole = RTC_SCENE_FLAG_ROBUST;

std::shared_ptr<RTCSceneTy> NewScene(RTCDevice device, int flags) {
  std::shared_ptr<RTCSceneTy> scene(rtcNewScene(device),
                                    [](RTCScene released) { rtcReleaseScene(released); });
  rtcSetSceneFlags(scene.get(), static_cast<RTCSceneFlags>(flags));
  return scene;
}

void Attach(RTCScene scene, RTCGeometry geometry) {
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
}

// What Embree asks in threads of its own.
struct Progress {
  const std::stop_token& stop;
  HandOver to_embree{}, from_embree{};
};

// Embree asks for each thousand triangles, once it has split them that far: a stop is obeyed
// within 0.1 s for a million triangles, within 2 s for the largest mesh.
void Commit(RTCScene scene, const std::stop_token& stop) {
  Progress progress{.stop = stop};
  progress.to_embree.Give();
  const auto goes_on = [](void* of, double) {
    auto& asked = *static_cast<Progress*>(of);
    asked.to_embree.Take();
    const bool is_wanted = !asked.stop.stop_requested();
    asked.from_embree.Give();
    return is_wanted;
  };
  rtcSetSceneProgressMonitorFunction(scene, goes_on, &progress);
  rtcCommitScene(scene);
  progress.from_embree.Take();
  rtcSetSceneProgressMonitorFunction(scene, nullptr, nullptr);
}

// Of the first error on this thread since it was last asked for.
absl::Status StatusOf(RTCDevice device, const std::stop_token& stop) {
  const RTCError error = rtcGetDeviceError(device);
  if (stop.stop_requested()) return absl::CancelledError("stopped");
  if (error == RTC_ERROR_NONE) return absl::OkStatus();
  return absl::ResourceExhaustedError("rays: out of memory for their hierarchies");
}

bool IsIn(const Instance& instance, CasterBvhs::Instances which) {
  return (which == CasterBvhs::Instances::kAll || instance.casts) &&
         instance.mesh->triangle_count() > 0;
}

}  // namespace

struct CasterBvhStore::Tree {
  std::shared_ptr<const PlacedTriangles> triangles;
  std::shared_ptr<RTCSceneTy> scene;

  size_t bytes() const { return kTreeBytes * triangles->instance().mesh->triangle_count(); }
};

// Of one who builds, or looks whether he has to; false: stop was requested while he waited.
class CasterBvhStore::Turn {
 public:
  Turn(CasterBvhStore& store, const std::stop_token& stop) : store_(store) {
    std::unique_lock lock(store_.mutex_);
    has_come_ = store_.is_free_.wait(lock, stop, [this] { return !store_.is_taken_; });
    if (has_come_) store_.is_taken_ = true;
  }
  Turn(const Turn&) = delete;
  ~Turn() {
    if (!has_come_) return;
    const std::lock_guard lock(store_.mutex_);
    store_.is_taken_ = false;
    store_.is_free_.notify_all();
  }

  explicit operator bool() const { return has_come_; }

 private:
  CasterBvhStore& store_;
  bool has_come_ = false;
};

// One CasterBvh in the making.
class CasterBvhStore::Build {
 public:
  Build(CasterBvhStore& store, const std::stop_token& stop, int scene_flags)
      : store_(store), device_(store.device_.get()), stop_(stop) {
    made_->top_ = NewScene(device_, scene_flags);
  }

  // To trace the instance as a whole.
  absl::Status AddTree(const std::shared_ptr<const Instance>& instance) {
    const auto tree = TreeOf(instance);
    if (!tree.ok()) return tree.status();
    // At the place it has already: a map that flattens has no inverse, which Embree would need.
    const RTCGeometry part = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(part, (*tree)->scene.get());
    Attach(made_->top_.get(), part);
    made_->own_bytes_ += kInstanceBytes;
    Note(*tree, store_.trees_[instance.get()].is_kept(), *instance);
    return absl::OkStatus();
  }

  // To trace its triangles among all.
  absl::Status AddTriangles(const std::shared_ptr<const Instance>& instance) {
    const auto triangles = TrianglesOf(instance);
    if (!triangles.ok()) return triangles.status();
    rtcAttachGeometry(made_->top_.get(), (*triangles)->geometry());
    made_->own_bytes_ += kTreeBytes * instance->mesh->triangle_count();
    Note(*triangles, store_.triangles_[instance.get()].is_kept(), *instance);
    return absl::OkStatus();
  }

  // The first error of `added` and of what is over the parts is its status.
  std::shared_ptr<const CasterBvh> Finish(absl::Status added, const Scene& scene,
                                          Newest& newest) && {
    if (added.ok()) {
      Commit(made_->top_.get(), stop_);
      added = StatusOf(device_, stop_);
    }
    if (!added.ok()) return Failed(std::move(added));
    newest.table = scene.shared_instances();
    newest.bvh.Put(made_, all_are_kept_ ? store_.budget_ : nullptr);
    return made_;
  }

  static std::shared_ptr<const CasterBvh> Failed(absl::Status status) {
    const std::shared_ptr<CasterBvh> failed(new CasterBvh());
    failed->status_ = std::move(status);
    return failed;
  }

 private:
  void Note(std::shared_ptr<const void> part, bool is_kept, const Instance& instance) {
    made_->parts_.push_back(std::move(part));
    made_->triangle_count_ += instance.mesh->triangle_count();
    all_are_kept_ = all_are_kept_ && is_kept;
  }

  absl::StatusOr<std::shared_ptr<const PlacedTriangles>> TrianglesOf(
      const std::shared_ptr<const Instance>& instance) {
    auto& slot = store_.triangles_[instance.get()];
    if (auto known = slot.Find()) return known;
    const auto made = std::make_shared<PlacedTriangles>(instance, device_, stop_);
    if (auto status = StatusOf(device_, stop_); !status.ok()) return status;
    slot.Put(made, store_.budget_);
    return made;
  }

  absl::StatusOr<std::shared_ptr<const Tree>> TreeOf(
      const std::shared_ptr<const Instance>& instance) {
    auto& slot = store_.trees_[instance.get()];
    if (auto known = slot.Find()) return known;
    const auto triangles = TrianglesOf(instance);
    if (!triangles.ok()) return triangles.status();
    const auto made = std::make_shared<Tree>(Tree{*triangles, NewScene(device_, kTracedAsAWhole)});
    rtcAttachGeometry(made->scene.get(), (*triangles)->geometry());
    ++store_.built_;
    Commit(made->scene.get(), stop_);
    if (auto status = StatusOf(device_, stop_); !status.ok()) return status;
    const bool has_kept_triangles = store_.triangles_[instance.get()].is_kept();
    slot.Put(made, has_kept_triangles ? store_.budget_ : nullptr);
    return made;
  }

  CasterBvhStore& store_;
  const RTCDevice device_;
  const std::stop_token& stop_;
  const std::shared_ptr<CasterBvh> made_{new CasterBvh()};
  bool all_are_kept_ = true;
};

std::shared_ptr<const CasterBvh> CasterBvhStore::Newest::Find(const Scene& scene) const {
  return table.lock() == scene.shared_instances() ? bvh.Find() : nullptr;
}

CasterBvhStore::CasterBvhStore(MemoryBudget* budget)
    : device_(rtcNewDevice(nullptr), [](RTCDevice device) { rtcReleaseDevice(device); }),
      budget_(budget) {}

CasterBvhStore::~CasterBvhStore() = default;

void CasterBvhStore::KeepOnlyWhatIsIn(const Scene& scene) {
  std::set<const Instance*> there;
  for (const auto& [id, instance] : scene.instances()) there.insert(instance.get());
  const auto is_gone = [&](const auto& known) { return !there.contains(known.first); };
  for (Newest* newest : {&newest_[0], &newest_[1], &newest_flat_}) {
    if (newest->table.lock() != scene.shared_instances()) newest->bvh.Release();
  }
  std::erase_if(trees_, is_gone);
  std::erase_if(triangles_, is_gone);
}

std::shared_ptr<const CasterBvh> CasterBvhStore::Of(const Scene& scene, CasterBvhs::Instances which,
                                                    const std::stop_token& stop) {
  const Turn turn(*this, stop);
  if (!turn) return Build::Failed(absl::CancelledError("stopped"));
  Newest& newest = newest_[which == CasterBvhs::Instances::kCasting ? 0 : 1];
  if (auto bvh = newest.Find(scene)) return bvh;
  KeepOnlyWhatIsIn(scene);
  Build build(*this, stop, kTracedAsAWhole);
  absl::Status added;
  for (const auto& [id, instance] : scene.instances()) {
    if (added.ok() && IsIn(*instance, which)) added = build.AddTree(instance);
  }
  return std::move(build).Finish(std::move(added), scene, newest);
}

std::shared_ptr<const CasterBvh> CasterBvhStore::Flat(const Scene& scene,
                                                      const std::stop_token& stop) {
  const Turn turn(*this, stop);
  if (!turn) return Build::Failed(absl::CancelledError("stopped"));
  if (auto bvh = newest_flat_.Find(scene)) return bvh;
  KeepOnlyWhatIsIn(scene);
  Build build(*this, stop, RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION);
  absl::Status added;
  for (const auto& [id, instance] : scene.instances()) {
    if (!added.ok() || !IsIn(*instance, CasterBvhs::Instances::kCasting)) continue;
    added = build.AddTriangles(instance);
  }
  ++built_;
  return std::move(build).Finish(std::move(added), scene, newest_flat_);
}

}  // namespace penumbra
