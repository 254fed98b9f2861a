#include "proto/convert/view_convert.h"

#include <cmath>

#include "proto/convert/geometry_convert.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

// Both ways of five faces each, of a light that shines from both sides.
constexpr int kMaxFaces = 10;

bool IsFiniteView(const LightView& view) {
  for (const DVec3& v :
       {view.frame.origin, view.frame.axes.s, view.frame.axes.t, view.frame.axes.n, view.eye,
        DVec3(view.window.min, view.near), DVec3(view.window.max, view.far)}) {
    for (int c = 0; c < 3; ++c) {
      if (!std::isfinite(v[c])) return false;
    }
  }
  return true;
}

absl::Status Invalid(const char* reason, const std::string& field, const std::string& text) {
  return FieldError(absl::StatusCode::kInvalidArgument, reason, field, text);
}

}  // namespace

v1::LightView ToProto(const LightView& view) {
  v1::LightView proto;
  *proto.mutable_origin() = ToProto(view.frame.origin);
  *proto.mutable_axis_s() = ToProto(view.frame.axes.s);
  *proto.mutable_axis_t() = ToProto(view.frame.axes.t);
  *proto.mutable_axis_n() = ToProto(view.frame.axes.n);
  proto.set_from_infinity(view.from_infinity);
  *proto.mutable_eye() = ToProto(view.eye);
  proto.set_min_x(view.window.min.x);
  proto.set_min_y(view.window.min.y);
  proto.set_max_x(view.window.max.x);
  proto.set_max_y(view.window.max.y);
  proto.set_width(view.width);
  proto.set_height(view.height);
  proto.set_near(view.near);
  proto.set_far(view.far);
  return proto;
}

LightView FromProto(const v1::LightView& proto) {
  return {.frame = {.origin = FromProto(proto.origin()),
                    .axes = {.s = FromProto(proto.axis_s()),
                             .t = FromProto(proto.axis_t()),
                             .n = FromProto(proto.axis_n())}},
          .from_infinity = proto.from_infinity(),
          .eye = FromProto(proto.eye()),
          .window = {.min = {proto.min_x(), proto.min_y()}, .max = {proto.max_x(), proto.max_y()}},
          .width = proto.width(),
          .height = proto.height(),
          .near = proto.near(),
          .far = proto.far()};
}

absl::Status CheckView(const LightView& view, const std::string& field, const SceneLimits& limits) {
  if (!IsFiniteView(view)) return Invalid("NON_FINITE", field, "need finite numbers");
  if (view.window.empty()) return Invalid("RANGE", field, "found an empty window, need some of it");
  const uint64_t width = view.width, height = view.height;
  if (width > 0 && height > 0 && width <= limits.max_receiver_side &&
      height <= limits.max_receiver_side && width * height <= limits.max_receiver_texels) {
    return absl::OkStatus();
  }
  return Invalid("RANGE", field,
                 "found " + std::to_string(width) + " by " + std::to_string(height) +
                     " pixels, need sides of 1 to " + std::to_string(limits.max_receiver_side) +
                     " and at most " + std::to_string(limits.max_receiver_texels) + " pixels");
}

absl::Status CheckFaceCount(int count, const std::string& field) {
  if (count <= kMaxFaces) return absl::OkStatus();
  return Invalid("RANGE", field,
                 "found " + std::to_string(count) + ", need at most " + std::to_string(kMaxFaces));
}

}  // namespace penumbra
