#include "render/technique/soft_texture/gl/sample_term.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "absl/strings/str_cat.h"
#include "render/gl/program.h"

namespace penumbra::texture_gl {
namespace {

constexpr double kPi = std::numbers::pi;

// The least cosine that an area is divided by: a sphere's sample on the very rim stands for no more
// than this many times its share of the disc. Nearer to the rim lies 1e-6 of the disc.
constexpr double kLeastCosine = 1e-3;

// In place of a cosine: everything is inside.
constexpr float kNoCone = -2;

// A cone's edge is no sharper in the cosine than single precision can tell.
constexpr double kLeastRamp = 1e-7;

constexpr char kGlsl[] = R"glsl(
struct LightSample { vec4 place, normal; };
struct Emitter { vec4 emission, kind; };

float Facing(float cosine, bool two_sided) { return two_sided ? abs(cosine) : max(0.0, cosine); }

// The square of a linear ramp in the cosine.
float ConeShare(float cosine, float cos_outer, float cos_inner) {
  if (cos_outer < -1.0) return 1.0;
  float ramp = clamp((cosine - cos_outer) / max(kLeastRamp, cos_inner - cos_outer), 0.0, 1.0);
  return ramp * ramp;
}

float SampleTerm(LightSample s, Emitter emitter, vec3 point, vec3 normal, bool two_sided) {
  if (emitter.kind.x == kSky) {
    return s.place.w * Facing(dot(normal, s.place.xyz), two_sided) / kPi;
  }
  vec3 to_light = s.place.xyz - point;
  float distance2 = dot(to_light, to_light);
  if (distance2 == 0.0) return 0.0;
  // Each divided by the distance squared, so that nothing is too large or too small on the way.
  float received = Facing(dot(normal, to_light), two_sided) / distance2;
  float along_axis = -dot(s.normal.xyz, to_light);
  if (emitter.kind.x == kPoint) {
    float cosine = along_axis * inversesqrt(distance2);
    return ConeShare(cosine, emitter.kind.z, emitter.kind.w) * received *
           inversesqrt(distance2) / kPi;
  }
  float emitted = Facing(along_axis, emitter.kind.y != 0.0) / distance2;
  return s.place.w * received * emitted / kPi;
}
)glsl";

struct EmitterVisitor {
  GpuEmitter operator()(const RectangleLight& light) const {
    return Surface(light.radiance, light.two_sided);
  }
  GpuEmitter operator()(const DiskLight& light) const {
    return Surface(light.radiance, light.two_sided);
  }
  GpuEmitter operator()(const SphereLight& light) const { return Surface(light.radiance, false); }
  GpuEmitter operator()(const PointLight& light) const {
    return {Vec4(light.intensity, 0),
            Vec4(static_cast<float>(Emitter::kPoint), 0, kNoCone, kNoCone)};
  }
  GpuEmitter operator()(const SpotLight& light) const {
    return {Vec4(light.intensity, 0),
            Vec4(static_cast<float>(Emitter::kPoint), 0, std::cos(light.outer_angle),
                 std::cos(light.inner_angle))};
  }
  GpuEmitter operator()(const DistantLight& light) const {
    return {Vec4(light.irradiance, 0), Vec4(static_cast<float>(Emitter::kSky), 0, 0, 0)};
  }

 private:
  static GpuEmitter Surface(Vec3 radiance, bool two_sided) {
    return {Vec4(radiance, 0),
            Vec4(static_cast<float>(Emitter::kSurface), two_sided ? 1.0f : 0.0f, 0, 0)};
  }
};

// Normal and area, or axis, or factor, of the sample at a place in the world or in a direction.
struct SampleVisitor {
  DVec3 place;
  DVec3 target;

  struct Share {
    DVec3 normal;
    double area;
  };

  Share operator()(const RectangleLight& light) const {
    const DVec3 cross = glm::cross(DVec3(light.edge_u), DVec3(light.edge_v));
    return {glm::normalize(cross), glm::length(cross)};
  }
  Share operator()(const DiskLight& light) const {
    return {glm::normalize(DVec3(light.normal)), kPi * double{light.radius} * light.radius};
  }
  Share operator()(const SphereLight& light) const {
    const DVec3 to_target = target - DVec3(light.center);
    const DVec3 out = glm::normalize(place - DVec3(light.center));
    const bool centered = glm::dot(to_target, to_target) == 0;
    const DVec3 towards = centered ? DVec3(0, 1, 0) : glm::normalize(to_target);
    return {out, kPi * double{light.radius} * light.radius /
                     std::max(kLeastCosine, glm::dot(out, towards))};
  }
  Share operator()(const PointLight&) const { return {DVec3(0.0), 1}; }
  Share operator()(const SpotLight& light) const {
    return {glm::normalize(DVec3(light.direction)), 1};
  }
  // Even over the disc of directions as projected on a surface that faces the light.
  Share operator()(const DistantLight& light) const {
    const double cosine = glm::dot(place, glm::normalize(DVec3(light.to_light)));
    return {DVec3(0.0), 1 / std::max(kLeastCosine, cosine)};
  }
};

double Facing(double cosine, bool two_sided) {
  return two_sided ? std::abs(cosine) : std::max(0.0, cosine);
}

double ConeShare(double cosine, double cos_outer, double cos_inner) {
  if (cos_outer < -1) return 1;
  const double ramp =
      std::clamp((cosine - cos_outer) / std::max(kLeastRamp, cos_inner - cos_outer), 0.0, 1.0);
  return ramp * ramp;
}

}  // namespace

GpuEmitter EmitterOf(const AreaLight& light) { return std::visit(EmitterVisitor{}, light.shape); }

std::vector<GpuLightSample> LightSamplesForGpu(const AreaLight& light,
                                               std::span<const LightSample> samples,
                                               const Parallelogram& patch) {
  std::vector<GpuLightSample> converted;
  converted.reserve(samples.size());
  const DVec3 target(patch.At(Vec2(0.5f)));
  for (const LightSample& sample : samples) {
    const DVec3 place(sample.point);
    const auto share = std::visit(SampleVisitor{place, target}, light.shape);
    const DVec3 from_origin = sample.at_infinity ? place : place - DVec3(patch.origin);
    converted.push_back(
        {Vec4(Vec3(from_origin), static_cast<float>(share.area)), Vec4(Vec3(share.normal), 0)});
  }
  return converted;
}

double SampleTerm(const GpuLightSample& sample, const GpuEmitter& emitter, DVec3 point,
                  DVec3 normal, bool two_sided) {
  const auto kind = static_cast<Emitter>(static_cast<int32_t>(emitter.kind.x));
  const DVec3 place(sample.place);
  const double area = sample.place.w;
  if (kind == Emitter::kSky) return area * Facing(glm::dot(normal, place), two_sided) / kPi;
  const DVec3 to_light = place - point;
  const double r2 = glm::dot(to_light, to_light);
  if (r2 == 0) return 0;
  const double r = std::sqrt(r2);
  const double cos_theta = Facing(glm::dot(normal, to_light) / r, two_sided);
  const double along_axis = -glm::dot(DVec3(sample.normal), to_light) / r;
  if (kind == Emitter::kPoint) {
    return ConeShare(along_axis, emitter.kind.z, emitter.kind.w) * cos_theta / (kPi * r2);
  }
  return area * cos_theta * Facing(along_axis, emitter.kind.y != 0) / (kPi * r2);
}

std::string SampleTermGlsl() {
  return absl::StrCat(gl::GlslConstant("kPi", kPi), gl::GlslConstant("kLeastRamp", kLeastRamp),
                      gl::GlslConstant("kPoint", static_cast<double>(Emitter::kPoint)),
                      gl::GlslConstant("kSky", static_cast<double>(Emitter::kSky)), kGlsl);
}

}  // namespace penumbra::texture_gl
