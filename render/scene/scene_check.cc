#include "render/scene/scene_check.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "render/scene/field_error.h"
#include "render/scene/receiver_place.h"
#include "render/scene/scene.h"
#include "render/scene/texture_size.h"

namespace penumbra {
namespace {

// Collects the first error of a list of checks on one object.
class Checker {
 public:
  Checker(std::string_view path, const SceneLimits& limits) : path_(path), limits_(limits) {}

  absl::Status status() const { return status_; }

  void Fail(const char* reason, const char* field, std::string found_and_need,
            absl::StatusCode code = absl::StatusCode::kInvalidArgument) {
    if (!status_.ok()) return;
    status_ = FieldError(code, reason, absl::StrCat(path_, ".", field), found_and_need);
  }
  void Id(const std::string& id) {
    if (status_.ok()) status_ = CheckId(id, absl::StrCat(path_, ".id"));
  }
  void Finite(const char* field, Vec3 v) {
    if (!IsFinite(v)) {
      Fail("NON_FINITE", field, absl::StrCat("found ", Text(v), ", need finite numbers"));
    }
  }
  void Finite(const char* field, float x) {
    if (!IsFinite(x))
      Fail("NON_FINITE", field, absl::StrCat("found ", x, ", need a finite number"));
  }
  void Coordinate(const char* field, Vec3 v) {
    Finite(field, v);
    const Vec3 size = glm::abs(v);
    if (std::max({size.x, size.y, size.z}) > limits_.max_coordinate) {
      Fail("OUT_OF_BOUNDS", field,
           absl::StrCat("found ", Text(v), ", need at most ", limits_.max_coordinate, " in size"));
    }
  }
  void Emission(const char* field, Vec3 v) {
    Finite(field, v);
    if (!(v.x >= 0 && v.y >= 0 && v.z >= 0)) {
      Fail("RANGE", field, absl::StrCat("found ", Text(v), ", need numbers of at least 0"));
    }
  }
  void Reflectance(const char* field, Vec3 v) {
    Finite(field, v);
    const auto ok = [](float x) { return x >= 0 && x <= 1; };
    if (!(ok(v.x) && ok(v.y) && ok(v.z))) {
      Fail("RANGE", field, absl::StrCat("found ", Text(v), ", need numbers from 0 to 1"));
    }
  }
  void Direction(const char* field, Vec3 v) {
    Coordinate(field, v);
    if (glm::length(DVec3(v)) == 0) Fail("ZERO_LENGTH", field, "length is 0, need > 0");
  }
  void Range(const char* field, double x, double low, double high) {
    Finite(field, static_cast<float>(x));
    if (!(x >= low && x <= high)) {
      Fail("RANGE", field, absl::StrCat("found ", x, ", need ", low, " to ", high));
    }
  }
  void Radius(float radius) {
    Finite("radius", radius);
    if (radius > limits_.max_coordinate) {
      Fail("OUT_OF_BOUNDS", "radius",
           absl::StrCat("found ", radius, ", need at most ", limits_.max_coordinate));
    }
    if (!(radius > 0)) {
      Fail("ZERO_AREA", "radius",
           absl::StrCat("found ", radius, ", need > 0; a light without size is a point light"));
    }
  }
  // Two edges that span an area: neither has length 0, and they are not parallel.
  void Edges(Vec3 edge_u, Vec3 edge_v, const char* remedy) {
    Coordinate("edge_u", edge_u);
    Coordinate("edge_v", edge_v);
    const double u = glm::length(DVec3(edge_u)), v = glm::length(DVec3(edge_v));
    if (u == 0) Fail("ZERO_AREA", "edge_u", absl::StrCat("length is 0, need > 0", remedy));
    if (v == 0) Fail("ZERO_AREA", "edge_v", absl::StrCat("length is 0, need > 0", remedy));
    if (!(glm::length(glm::cross(DVec3(edge_u), DVec3(edge_v))) > 1e-7 * u * v)) {
      Fail("ZERO_AREA", "edge_v",
           absl::StrCat("is parallel to edge_u, need two directions", remedy));
    }
  }
  void Polygon(const PlanarPolygon& polygon) {
    if (!status_.ok()) return;
    status_ = WithFieldPrefix(CheckPolygon(polygon, limits_), path_ + ".");
  }
  void InstanceId(const std::string& id) {
    if (status_.ok()) status_ = CheckId(id, absl::StrCat(path_, ".instance_id"));
  }
  const SceneLimits& limits() const { return limits_; }

 private:
  static std::string Text(Vec3 v) { return absl::StrCat("(", v.x, ", ", v.y, ", ", v.z, ")"); }

  std::string path_;
  const SceneLimits& limits_;
  absl::Status status_;
};

constexpr char kUsePointLight[] = "; a light without size is a point light";

struct CheckShape {
  Checker& check;

  void operator()(const RectangleLight& light) const {
    check.Coordinate("corner", light.corner);
    check.Edges(light.edge_u, light.edge_v, kUsePointLight);
    check.Emission("radiance", light.radiance);
  }
  void operator()(const DiskLight& light) const {
    check.Coordinate("center", light.center);
    check.Direction("normal", light.normal);
    check.Radius(light.radius);
    check.Emission("radiance", light.radiance);
  }
  void operator()(const SphereLight& light) const {
    check.Coordinate("center", light.center);
    check.Radius(light.radius);
    check.Emission("radiance", light.radiance);
  }
  void operator()(const PointLight& light) const {
    check.Coordinate("position", light.position);
    check.Emission("intensity", light.intensity);
  }
  void operator()(const SpotLight& light) const {
    check.Coordinate("position", light.position);
    check.Direction("direction", light.direction);
    check.Emission("intensity", light.intensity);
    check.Range("outer_angle", light.outer_angle, 1e-4, std::numbers::pi / 2 + 1e-6);
    check.Range("inner_angle", light.inner_angle, 0, std::nextafter(light.outer_angle, 0.0f));
  }
  void operator()(const DistantLight& light) const {
    check.Direction("to_light", light.to_light);
    check.Range("angular_diameter", light.angular_diameter, 0, std::numbers::pi / 2 + 1e-6);
    check.Emission("irradiance", light.irradiance);
  }
};

struct CheckReceiverShape {
  Checker& check;

  void operator()(const Parallelogram& patch) const {
    check.Coordinate("origin", patch.origin);
    check.Edges(patch.edge_u, patch.edge_v, "");
  }
  void operator()(const Triangle& triangle) const {
    check.Coordinate("corner", triangle.corner);
    check.Edges(triangle.edge_u, triangle.edge_v, "");
  }
  void operator()(const PlanarPolygon& polygon) const { check.Polygon(polygon); }
  void operator()(const PlanarInstance& planar) const { check.InstanceId(planar.instance_id); }
  void operator()(const PlanarSurface& surface) const { check.InstanceId(surface.instance_id); }
};

// Sides that are asked for, and those that the receiver's size may choose.
void CheckGrid(const Receiver& receiver, Checker& check) {
  const SceneLimits& limits = check.limits();
  for (const auto& [name, side] :
       {std::pair{"width", receiver.width}, std::pair{"height", receiver.height},
        std::pair{"max_auto_side", receiver.max_auto_side}}) {
    check.Range(name, side, 0, limits.max_receiver_side);
  }
  check.Range("texels_per_metre", receiver.texels_per_metre, 0, kMaxTexelsPerMetre);
  const uint32_t most = receiver.max_auto_side > 0 ? receiver.max_auto_side : kMaxAutoSide;
  const uint64_t width = receiver.width > 0 ? receiver.width : most;
  const uint64_t height = receiver.height > 0 ? receiver.height : most;
  if (width * height > limits.max_receiver_texels) {
    check.Fail("QUOTA_TEXELS", "width",
               absl::StrCat("found ", width, " by ", height, " texels, need at most ",
                            limits.max_receiver_texels, " in all"),
               absl::StatusCode::kResourceExhausted);
  }
}

}  // namespace

absl::Status CheckInstance(const Instance& instance, std::string_view path,
                           const SceneLimits& limits) {
  Checker check(path, limits);
  check.Id(instance.id);
  if (!instance.mesh) check.Fail("MISSING_MESH", "mesh", "found none, need a mesh");
  for (int column = 0; column < 4; ++column) {
    check.Coordinate("world_from_mesh", instance.world_from_mesh[column]);
  }
  check.Reflectance("color", instance.color);
  check.Range("alpha_cutoff", instance.alpha_cutoff, 0, 1);
  if (instance.mesh && check.status().ok()) {
    if (instance.alpha_mask && instance.mesh->uvs().empty() && instance.mesh->vertex_count() > 0) {
      check.Fail("MISSING_UVS", "alpha_mask", "found a mask on a mesh without uvs, need uvs");
    }
    const Aabb bounds = WorldBounds(instance);
    if (!bounds.empty()) {
      check.Coordinate("world_from_mesh", bounds.min);
      check.Coordinate("world_from_mesh", bounds.max);
    }
  }
  return check.status();
}

absl::Status CheckLight(const AreaLight& light, std::string_view path, const SceneLimits& limits) {
  Checker check(path, limits);
  check.Id(light.id);
  std::visit(CheckShape{check}, light.shape);
  return check.status();
}

absl::Status CheckReceiver(const Receiver& receiver, std::string_view path,
                           const SceneLimits& limits) {
  Checker check(path, limits);
  check.Id(receiver.id);
  std::visit(CheckReceiverShape{check}, receiver.shape);
  CheckGrid(receiver, check);
  check.Reflectance("reflectance", receiver.reflectance);
  return check.status();
}

absl::Status CheckPatch(const Parallelogram& patch, std::string_view path) {
  const SceneLimits anywhere{.max_coordinate = std::numeric_limits<float>::max()};
  Checker check(path, anywhere);
  CheckReceiverShape{check}(patch);
  return check.status();
}

}  // namespace penumbra
