// Where a picture is taken from, and how much of it something fills.
//
//   Camera camera = FrameScene(scene.Bounds(), 16.0f / 9.0f);
//   double share = ViewedShare({camera, 16.0 / 9.0}, patch);
#pragma once

#include "absl/status/status.h"
#include "render/math/aabb.h"
#include "render/math/vec.h"
#include "render/scene/receiver.h"
#include "render/scene/scene_limits.h"

namespace penumbra {

struct Camera {
  Vec3 eye{0, 0, 1};
  Vec3 target{0.0f};
  Vec3 up{0, 1, 0};         // any length > 0; when it points along the view another is taken
  float fov_y_deg = 40.0f;  // the whole vertical opening, (0, 180)

  friend bool operator==(const Camera&, const Camera&) = default;
};

// Errors  kInvalidArgument, field paths "camera.eye" and so on: NON_FINITE, OUT_OF_BOUNDS (the
//         limits' coordinates), RANGE, as for an eye at its target
absl::Status CheckCamera(const Camera& camera, const SceneLimits& limits = {});

// Takes world to clip space with reversed depth (render/gl/draw.h): nothing is too far, and what is
// nearer than 1/10,000 of the way to the target is cut.
DMat4 ClipFromWorld(const Camera& camera, double aspect);

// The view from the front, right and above that just holds `bounds`. `aspect` is width over height.
Camera FrameScene(const Aabb& bounds, float aspect);

// What somebody looks at.
struct View {
  Camera camera;
  double aspect = 1.5;  // width over height, > 0
};

// Errors  those of CheckCamera; RANGE at "camera.aspect"
absl::Status CheckView(const View& view, const SceneLimits& limits = {});

// The part of the picture, in [0, 1], that `patch` fills, whichever side it shows and whatever
// stands before it.
double ViewedShare(const View& view, const Parallelogram& patch);

}  // namespace penumbra
