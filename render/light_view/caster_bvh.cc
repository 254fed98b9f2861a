#include "render/light_view/caster_bvh.h"

#include <embree3/rtcore.h>

#include <array>
#include <cstring>
#include <span>

namespace penumbra {
namespace {

std::shared_ptr<RTCSceneTy> NewScene(RTCDevice device, int flags) {
  std::shared_ptr<RTCSceneTy> scene(rtcNewScene(device),
                                    [](RTCScene released) { rtcReleaseScene(released); });
  rtcSetSceneFlags(scene.get(), static_cast<RTCSceneFlags>(flags));
  return scene;
}

// Empty where Embree has no memory for it.
template <typename T>
std::span<T> NewBuffer(RTCGeometry geometry, RTCBufferType type, RTCFormat format, size_t count) {
  void* const buffer = rtcSetNewGeometryBuffer(geometry, type, 0, format, sizeof(T), count);
  return {static_cast<T*>(buffer), buffer ? count : 0};
}

void Attach(RTCScene scene, RTCGeometry geometry) {
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
}

}  // namespace

struct CasterBvh::Caster {
  std::shared_ptr<const Instance> instance;
  std::shared_ptr<RTCGeometryTy> triangles;
  std::shared_ptr<RTCSceneTy> scene;

  bool is_cut() const { return instance->alpha_mask && !instance->mesh->uvs().empty(); }

  bool IsThere(uint32_t triangle, float u, float v) const {
    const Mesh& mesh = *instance->mesh;
    const uint32_t* const corners = &mesh.indices()[3 * size_t{triangle}];
    const Vec2 uv = (1 - u - v) * mesh.uvs()[corners[0]] + u * mesh.uvs()[corners[1]] +
                    v * mesh.uvs()[corners[2]];
    return instance->alpha_mask->At(uv) >= instance->alpha_cutoff;
  }

  // Drops the hits where the mask has a hole.
  static void Filter(const RTCFilterFunctionNArguments* args) {
    const auto& caster = *static_cast<const Caster*>(args->geometryUserPtr);
    for (unsigned i = 0; i < args->N; ++i) {
      if (args->valid[i] != -1) continue;
      const bool is_there =
          caster.IsThere(RTCHitN_primID(args->hit, args->N, i), RTCHitN_u(args->hit, args->N, i),
                         RTCHitN_v(args->hit, args->N, i));
      if (!is_there) args->valid[i] = 0;
    }
  }

  void Build(RTCDevice device) {
    const Mesh& mesh = *instance->mesh;
    const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    triangles.reset(geometry, [](RTCGeometry released) { rtcReleaseGeometry(released); });
    const auto vertices =
        NewBuffer<Vec3>(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, mesh.vertex_count());
    for (size_t v = 0; v < vertices.size(); ++v) {
      vertices[v] = TransformPoint(instance->world_from_mesh, mesh.positions()[v]);
    }
    using Corners = std::array<uint32_t, 3>;
    const auto indices = NewBuffer<Corners>(geometry, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3,
                                            mesh.triangle_count());
    if (!indices.empty()) {
      std::memcpy(indices.data(), mesh.indices().data(), mesh.indices().size_bytes());
    }
    if (is_cut()) {
      rtcSetGeometryUserData(geometry, this);
      rtcSetGeometryIntersectFilterFunction(geometry, Filter);
      rtcSetGeometryOccludedFilterFunction(geometry, Filter);
    }
    rtcCommitGeometry(geometry);
    scene = NewScene(device, RTC_SCENE_FLAG_ROBUST);
    rtcAttachGeometry(scene.get(), geometry);
    rtcCommitScene(scene.get());
  }
};

CasterBvhs::CasterBvhs()
    : device_(rtcNewDevice(nullptr), [](RTCDevice device) { rtcReleaseDevice(device); }) {}

std::shared_ptr<const CasterBvh::Caster> CasterBvhs::CasterOf(
    const std::shared_ptr<const Instance>& instance) {
  auto& known = casters_[instance.get()];
  if (auto caster = known.lock()) return caster;
  const auto caster = std::make_shared<Caster>();
  caster->instance = instance;
  caster->Build(device_.get());
  known = caster;
  return caster;
}

std::shared_ptr<const CasterBvh> CasterBvhs::Of(const Scene& scene, Instances which) {
  std::lock_guard lock(mutex_);
  auto& [newest_table, newest] = newest_[which == Instances::kCasting ? 0 : 1];
  auto bvh = newest.lock();
  if (bvh && newest_table.lock() == scene.shared_instances()) return bvh;
  std::erase_if(casters_, [](const auto& known) { return known.second.expired(); });

  const std::shared_ptr<CasterBvh> made(new CasterBvh());
  made->top_ = NewScene(device_.get(), RTC_SCENE_FLAG_ROBUST);
  for (const auto& [id, instance] : scene.instances()) {
    if (which == Instances::kCasting && !instance->casts) continue;
    if (instance->mesh->triangle_count() == 0) continue;
    made->casters_.push_back(CasterOf(instance));
    made->triangle_count_ += instance->mesh->triangle_count();
    // At the place it has already: a map that flattens has no inverse, which Embree would need.
    const RTCGeometry part = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(part, made->casters_.back()->scene.get());
    Attach(made->top_.get(), part);
  }
  rtcCommitScene(made->top_.get());
  if (made->NoteErrors(device_.get())) return made;
  newest = made;
  newest_table = scene.shared_instances();
  return made;
}

// The first error on this thread since it was last asked for.
bool CasterBvh::NoteErrors(RTCDevice device) {
  if (rtcGetDeviceError(device) == RTC_ERROR_NONE) return false;
  status_ = absl::ResourceExhaustedError("rays: out of memory for their hierarchies");
  return true;
}

std::shared_ptr<const CasterBvh> CasterBvhs::Flat(const Scene& scene) {
  const auto parts = Of(scene);
  std::lock_guard lock(mutex_);
  auto flat = newest_flat_.bvh.lock();
  if (flat && newest_flat_.table.lock() == scene.shared_instances()) return flat;
  const std::shared_ptr<CasterBvh> made(new CasterBvh());
  made->casters_ = parts->casters_;
  made->triangle_count_ = parts->triangle_count_;
  made->top_ = NewScene(device_.get(), RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION);
  for (const auto& caster : made->casters_) {
    rtcAttachGeometry(made->top_.get(), caster->triangles.get());
  }
  rtcCommitScene(made->top_.get());
  if (made->NoteErrors(device_.get())) return made;
  newest_flat_ = {scene.shared_instances(), made};
  return made;
}

}  // namespace penumbra
