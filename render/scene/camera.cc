#include "render/scene/camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "absl/strings/str_cat.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

constexpr double kRadians = std::numbers::pi / 180.0;

struct ViewFrame {
  DVec3 right, up, forward;
};

ViewFrame FrameOf(DVec3 forward, DVec3 up) {
  ViewFrame frame;
  frame.forward = glm::normalize(forward);
  DVec3 right = glm::cross(frame.forward, glm::normalize(up));
  if (glm::length(right) < 1e-6) {
    right = glm::cross(frame.forward,
                       std::abs(frame.forward.z) < 0.9 ? DVec3(0, 0, -1) : DVec3(0, 1, 0));
  }
  frame.right = glm::normalize(right);
  frame.up = glm::cross(frame.right, frame.forward);
  return frame;
}

// The part of a convex polygon with dot(plane, corner) ≥ 0.
std::vector<DVec4> CutBy(DVec4 plane, const std::vector<DVec4>& corners) {
  std::vector<DVec4> kept;
  for (size_t i = 0; i < corners.size(); ++i) {
    const DVec4& from = corners[i];
    const DVec4& to = corners[(i + 1) % corners.size()];
    const double a = glm::dot(plane, from), b = glm::dot(plane, to);
    if (a >= 0) kept.push_back(from);
    if ((a >= 0) != (b >= 0)) kept.push_back(from + a / (a - b) * (to - from));
  }
  return kept;
}

absl::Status Invalid(std::string_view reason, std::string_view field, std::string_view message) {
  return FieldError(absl::StatusCode::kInvalidArgument, reason, field, message);
}

absl::Status CheckPlace(std::string_view field, Vec3 place, const SceneLimits& limits) {
  if (!IsFinite(place)) return Invalid("NON_FINITE", field, "need finite numbers");
  if (glm::all(glm::lessThanEqual(glm::abs(place), Vec3(limits.max_coordinate)))) {
    return absl::OkStatus();
  }
  return Invalid("OUT_OF_BOUNDS", field,
                 absl::StrCat("found (", place.x, ", ", place.y, ", ", place.z,
                              "), need coordinates of at most ", limits.max_coordinate));
}

}  // namespace

absl::Status CheckCamera(const Camera& camera, const SceneLimits& limits) {
  if (auto status = CheckPlace("camera.eye", camera.eye, limits); !status.ok()) return status;
  if (auto status = CheckPlace("camera.target", camera.target, limits); !status.ok()) return status;
  if (!IsFinite(camera.up) || camera.up == Vec3(0)) {
    return Invalid("RANGE", "camera.up", "need finite numbers that are not all 0");
  }
  if (camera.eye == camera.target) {
    return Invalid("RANGE", "camera.target", "found the eye itself, need another point");
  }
  if (!(camera.fov_y_deg > 0 && camera.fov_y_deg < 180)) {
    return Invalid(
        "RANGE", "camera.fov_y_deg",
        absl::StrCat("found ", camera.fov_y_deg, ", need more than 0 and less than 180"));
  }
  return absl::OkStatus();
}

DMat4 ClipFromWorld(const Camera& camera, double aspect) {
  const DVec3 eye(camera.eye);
  const DVec3 to_target = DVec3(camera.target) - eye;
  const ViewFrame frame = FrameOf(to_target, DVec3(camera.up));
  constexpr double kNearShare = 1e-4;  // of the way to the target
  const double near = kNearShare * glm::length(to_target);
  const double y_scale = 1.0 / std::tan(0.5 * camera.fov_y_deg * kRadians);
  const double x_scale = y_scale / aspect;
  DMat4 clip(0.0);
  const auto set_row = [&](int row, DVec3 axis) {
    for (int i = 0; i < 3; ++i) clip[i][row] = axis[i];
    clip[3][row] = -glm::dot(axis, eye);
  };
  set_row(0, x_scale * frame.right);
  set_row(1, y_scale * frame.up);
  set_row(3, frame.forward);
  clip[3][2] = near;  // depth is near / distance
  return clip;
}

Camera FrameScene(const Aabb& bounds, float aspect) {
  const Aabb box = bounds.empty() ? Aabb{.min = Vec3(-1), .max = Vec3(1)} : bounds;
  constexpr double kAzimuth = 32.0 * kRadians, kElevation = 26.0 * kRadians;
  constexpr double kMargin = 1.04;
  Camera camera;
  const DVec3 to_eye(std::sin(kAzimuth) * std::cos(kElevation), std::sin(kElevation),
                     std::cos(kAzimuth) * std::cos(kElevation));
  const ViewFrame frame = FrameOf(-to_eye, DVec3(camera.up));
  const double tan_y = std::tan(0.5 * camera.fov_y_deg * kRadians) / kMargin;
  const double tan_x = tan_y * aspect;
  const DVec3 center(box.center());
  double distance = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const DVec3 p((corner & 1) ? box.max.x : box.min.x, (corner & 2) ? box.max.y : box.min.y,
                  (corner & 4) ? box.max.z : box.min.z);
    const DVec3 d = p - center;
    const double nearer = -glm::dot(d, frame.forward);
    distance = std::max({distance, nearer + std::abs(glm::dot(d, frame.right)) / tan_x,
                         nearer + std::abs(glm::dot(d, frame.up)) / tan_y});
  }
  if (distance == 0) distance = 1;  // a single point
  camera.target = box.center();
  camera.eye = Vec3(center + distance * to_eye);
  return camera;
}

absl::Status CheckView(const View& view, const SceneLimits& limits) {
  if (absl::Status status = CheckCamera(view.camera, limits); !status.ok()) return status;
  if (std::isfinite(view.aspect) && view.aspect > 0) return absl::OkStatus();
  return Invalid("RANGE", "camera.aspect",
                 absl::StrCat("found ", view.aspect, ", need a number > 0"));
}

double ViewedShare(const View& view, const Parallelogram& patch) {
  const DMat4 clip_from_world = ClipFromWorld(view.camera, view.aspect);
  std::vector<DVec4> corners;
  for (const Vec2 uv : {Vec2(0, 0), Vec2(1, 0), Vec2(1, 1), Vec2(0, 1)}) {
    corners.push_back(clip_from_world * DVec4(DVec3(patch.At(uv)), 1));
  }
  // Not nearer than the near plane (z ≤ w), and within the picture (|x| ≤ w, |y| ≤ w).
  for (const DVec4 plane : {DVec4(0, 0, -1, 1), DVec4(1, 0, 0, 1), DVec4(-1, 0, 0, 1),
                            DVec4(0, 1, 0, 1), DVec4(0, -1, 0, 1)}) {
    corners = CutBy(plane, corners);
  }
  double twice = 0;  // in a picture of 2 × 2
  for (size_t i = 0; i < corners.size(); ++i) {
    const DVec4 a = corners[i] / corners[i].w;
    const DVec4 b = corners[(i + 1) % corners.size()] / corners[(i + 1) % corners.size()].w;
    twice += a.x * b.y - a.y * b.x;
  }
  return std::min(1.0, std::abs(twice) / 8);
}

}  // namespace penumbra
