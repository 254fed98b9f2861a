#include "tests/support/ldi_study.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <span>
#include <utility>

#include "client/cli/shadow_plan.h"
#include "render/light_view/raster_depth_source.h"
#include "render/light_view/ray_depth_source.h"
#include "render/light_view/split_depth_source.h"
#include "render/light_view/view_fit.h"
#include "render/math/parallel_for.h"
#include "render/scene/camera.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {
namespace {

constexpr uint32_t kCameraSide = 512;
constexpr size_t kPacket = 16;
constexpr const char* kFloorId = "floor-under-all";
// Of the way to a sample: short of the light itself.
constexpr float kNearlyThere = 0.9999f;

double NowMs() {
  return std::chrono::duration<double, std::milli>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

Aabb BoundsOf(const std::vector<Instance>& instances) {
  Aabb bounds;
  for (const Instance& instance : instances) bounds.Add(WorldBounds(instance));
  return bounds;
}

// Three rows of small triangles, of every second triangle with the middle one in three.
MeshGeometry InTenParts(const Mesh& mesh) {
  using Parts = std::vector<std::array<uint32_t, 3>>;
  const Parts around = {{0, 1, 4}, {1, 5, 4}, {1, 2, 5}, {2, 6, 5},
                        {2, 3, 6}, {4, 5, 7}, {5, 6, 8}, {7, 8, 9}};
  const Parts middle = {{5, 8, 7}}, middle_in_three = {{5, 8, 10}, {8, 7, 10}, {7, 5, 10}};
  MeshGeometry fine;
  for (size_t t = 0; t < mesh.triangle_count(); ++t) {
    const auto first = static_cast<uint32_t>(fine.positions.size());
    const auto corner = [&](int k) { return mesh.positions()[mesh.indices()[3 * t + k]]; };
    const Vec3 a = corner(0), u = (corner(1) - a) / 3.0f, v = (corner(2) - a) / 3.0f;
    for (int j = 0; j <= 3; ++j) {
      for (int i = 0; i <= 3 - j; ++i) {
        fine.positions.push_back(a + static_cast<float>(i) * u + static_cast<float>(j) * v);
      }
    }
    fine.positions.push_back(a + 2.0f / 3.0f * u + 5.0f / 3.0f * v);
    for (const Parts* parts : {&around, t % 2 == 0 ? &middle : &middle_in_three}) {
      for (const auto& part : *parts) {
        for (const uint32_t k : part) fine.indices.push_back(first + k);
      }
    }
  }
  return fine;
}

struct Packet {
  alignas(64) RTCRay16 rays{};
  alignas(64) int valid[kPacket];

  void Start(std::span<const Vec3> points) {
    for (size_t k = 0; k < kPacket; ++k) {
      const Vec3 p = points[std::min(k, points.size() - 1)];
      valid[k] = k < points.size() ? -1 : 0;
      rays.org_x[k] = p.x, rays.org_y[k] = p.y, rays.org_z[k] = p.z;
      rays.mask[k] = ~0u;
    }
  }
  void Aim(Vec3 target) {
    for (size_t k = 0; k < kPacket; ++k) {
      rays.dir_x[k] = target.x - rays.org_x[k];
      rays.dir_y[k] = target.y - rays.org_y[k];
      rays.dir_z[k] = target.z - rays.org_z[k];
      rays.tnear[k] = 0.0f;
      rays.tfar[k] = kNearlyThere;
    }
  }
  size_t VisibleCount() const {
    size_t count = 0;
    for (size_t k = 0; k < kPacket; ++k) count += valid[k] != 0 && rays.tfar[k] > 0;
    return count;
  }
};

// A little nearer than the layers, so that what they lie on is not in the way.
std::vector<Vec3> LayerPoints(const AttenuationLdi& ldi) {
  std::vector<Vec3> points;
  for (const LdiFace& face : ldi.faces) {
    for (size_t p = 0; p + 1 < face.offsets.size(); ++p) {
      const DVec2 center(static_cast<double>(p % face.view.width) + 0.5,
                         static_cast<double>(p / face.view.width) + 0.5);
      for (uint32_t k = face.offsets[p]; k < face.offsets[p + 1]; ++k) {
        points.emplace_back(face.view.PointAt(center, 0.999 * double{face.depths[k]}));
      }
    }
  }
  return points;
}

}  // namespace

std::shared_ptr<const Scene> OnAFloor(std::vector<Instance> instances) {
  const Aabb bounds = BoundsOf(instances);
  const Parallelogram floor = FloorUnder(bounds);
  const Vec3 o = floor.origin, u = floor.edge_u, v = floor.edge_v;
  SceneDelta delta{.upsert_instances = std::move(instances)};
  delta.upsert_instances.push_back(
      {.id = kFloorId,
       .mesh = MeshOf({.positions = {o, o + u, o + u + v, o + v}, .indices = {0, 1, 2, 0, 2, 3}})});
  AreaLight light = LightAbove(bounds);
  light.id = "light";
  std::get<RectangleLight>(light.shape).two_sided = false;
  delta.upsert_lights = {light};
  return Scene::Empty("study")->Apply(delta).value();
}

std::vector<Instance> Subdivided(const std::vector<Instance>& instances) {
  std::vector<Instance> fine = instances;
  for (Instance& instance : fine) instance.mesh = MeshOf(InTenParts(*instance.mesh));
  return fine;
}

LdiStudy::LdiStudy(std::shared_ptr<const Scene> scene, int threads)
    : arena_(threads), scene_(std::move(scene)), light_(*scene_->FindLight("light")) {
  bvh_ = bvhs_.Of(*scene_);
  sources_.push_back(std::make_unique<RasterDepthSource>(*scene_, arena_));
  sources_.push_back(std::make_unique<RayDepthSource>(bvh_, arena_));
  sources_.push_back(std::make_unique<SplitDepthSource>(*scene_, bvhs_, arena_));
  ChooseSource();
  Aabb bounds;
  for (const auto& [id, instance] : scene_->instances()) {
    if (id != kFloorId) bounds.Add(WorldBounds(*instance));
  }
  FindCameraPoints(bounds);
}

// By the quickest of some runs each, in turn: others may disturb the rest.
void LdiStudy::ChooseSource() {
  constexpr int kRuns = 4;  // the first of them to warm up
  double least = std::numeric_limits<double>::infinity();
  DepthSource* quickest = nullptr;
  for (int run = 0; run < kRuns; ++run) {
    for (const auto& source : sources_) {
      source_ = source.get();
      const double start = NowMs();
      (void)Build({.samples = 8});
      const double took = NowMs() - start;
      if (run == 0 || took >= least) continue;
      quickest = source_;
      least = took;
    }
  }
  source_ = quickest;
}

AttenuationLdi LdiStudy::Build(const LdiOptions& options) {
  const auto passes = LdiPasses::Create(*scene_, light_, options, *source_, arena_).value();
  const absl::Status status = passes->Advance(passes->sample_count(), {});
  if (!status.ok()) std::abort();
  return passes->Finish();
}

void LdiStudy::FindCameraPoints(const Aabb& bounds) {
  CameraPoints& seen = camera_points_;
  seen.width = seen.height = kCameraSide;
  const size_t pixels = size_t{seen.width} * seen.height;
  seen.points.resize(pixels), seen.normals.resize(pixels), seen.is_hit.resize(pixels);
  const DMat4 world_from_clip = glm::inverse(ClipFromWorld(FrameScene(bounds, 1.0f), 1.0));
  ray_offset_ = 1e-4f * glm::length(bounds.extent());
  const auto from_clip = [&](DVec2 at, double depth) {
    const DVec4 p = world_from_clip * DVec4(at, depth, 1.0);
    return DVec3(p) / p.w;
  };
  RunIn(arena_, [&] {
    ParallelFor(pixels, [&](size_t i) {
      const DVec2 at(2 * (static_cast<double>(i % seen.width) + 0.5) / seen.width - 1,
                     1 - 2 * (static_cast<double>(i / seen.width) + 0.5) / seen.height);
      const DVec3 from = from_clip(at, 1.0);
      const Vec3 origin(from), along(glm::normalize(from_clip(at, 0.5) - from));
      RTCIntersectContext context;
      rtcInitIntersectContext(&context);
      RTCRayHit ray{};
      ray.ray.org_x = origin.x, ray.ray.org_y = origin.y, ray.ray.org_z = origin.z;
      ray.ray.dir_x = along.x, ray.ray.dir_y = along.y, ray.ray.dir_z = along.z;
      ray.ray.tfar = std::numeric_limits<float>::infinity();
      ray.ray.mask = ~0u;
      ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
      rtcIntersect1(bvh_->embree(), &context, &ray);
      seen.is_hit[i] = ray.hit.geomID != RTC_INVALID_GEOMETRY_ID;
      const Vec3 normal = glm::normalize(Vec3(ray.hit.Ng_x, ray.hit.Ng_y, ray.hit.Ng_z));
      seen.points[i] = origin + ray.ray.tfar * along;
      seen.normals[i] = glm::dot(normal, along) > 0 ? -normal : normal;
    });
  });
}

std::vector<LightSample> LdiStudy::Samples(const LdiOptions& options) const {
  return SampleLight(light_, options.samples, options.seed, scene_->Bounds().center());
}

float LdiStudy::Traced(Vec3 point, Vec3 normal, const std::vector<LightSample>& samples) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  const Vec3 origin = point + ray_offset_ * normal;
  int visible = 0;
  for (const LightSample& sample : samples) {
    const Vec3 to = sample.point - origin;
    if (glm::dot(to, normal) <= 0) continue;
    RTCRay ray{};
    ray.org_x = origin.x, ray.org_y = origin.y, ray.org_z = origin.z;
    ray.dir_x = to.x, ray.dir_y = to.y, ray.dir_z = to.z;
    ray.tfar = kNearlyThere;
    ray.mask = ~0u;
    rtcOccluded1(bvh_->embree(), &context, &ray);
    visible += ray.tfar > 0;
  }
  return static_cast<float>(visible) / static_cast<float>(samples.size());
}

LdiError LdiStudy::Compare(const AttenuationLdi& ldi, const LdiOptions& options) {
  const CameraPoints& seen = camera_points_;
  const std::vector<LightSample> samples = Samples(options);
  LdiError error;
  error.traced.resize(seen.points.size()), error.found.resize(seen.points.size());
  RunIn(arena_, [&] {
    ParallelFor(seen.points.size(), [&](size_t i) {
      if (!seen.is_hit[i]) return;
      error.traced[i] = Traced(seen.points[i], seen.normals[i], samples);
      error.found[i] = Visibility(ldi, seen.points[i], seen.normals[i]);
    });
  });
  std::vector<double> off;
  for (size_t i = 0; i < seen.points.size(); ++i) {
    if (!seen.is_hit[i]) continue;
    off.push_back(std::abs(double{error.found[i]} - error.traced[i]));
    error.mean += off.back();
    error.bias += double{error.found[i]} - error.traced[i];
  }
  error.points = off.size();
  if (off.empty()) return error;
  error.mean /= static_cast<double>(off.size());
  error.bias /= static_cast<double>(off.size());
  const auto p99 = off.begin() + static_cast<std::ptrdiff_t>(off.size() * 99 / 100);
  std::nth_element(off.begin(), p99, off.end());
  error.p99 = *p99;
  return error;
}

size_t LdiStudy::TraceFromLayers(const AttenuationLdi& ldi, const LdiOptions& options) {
  const std::vector<LightSample> samples = Samples(options);
  const std::vector<Vec3> points = LayerPoints(ldi);
  std::atomic<size_t> visible = 0;
  RunIn(arena_, [&] {
    ParallelFor((points.size() + kPacket - 1) / kPacket, [&](size_t first) {
      RTCIntersectContext context;
      rtcInitIntersectContext(&context);
      context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
      Packet packet;
      packet.Start(std::span(points).subspan(first * kPacket));
      size_t here = 0;
      for (const LightSample& sample : samples) {
        packet.Aim(sample.point);
        rtcOccluded16(packet.valid, bvh_->embree(), &context, &packet.rays);
        here += packet.VisibleCount();
      }
      visible += here;
    });
  });
  return visible;
}

double MeanLayers(const AttenuationLdi& ldi) {
  size_t layers = 0, pixels = 0;
  for (const LdiFace& face : ldi.faces) {
    layers += face.layer_count();
    for (size_t p = 0; p + 1 < face.offsets.size(); ++p) {
      pixels += face.offsets[p + 1] > face.offsets[p];
    }
  }
  return static_cast<double>(layers) / static_cast<double>(std::max<size_t>(pixels, 1));
}

}  // namespace penumbra::testing
