// What shadows are computed on point by point, rather than on a patch.
//
//   PointReceiver picture = PicturePixels{.camera = camera, .width = 1920, .height = 1080};
//   if (auto status = Check(picture, limits); !status.ok()) …
//   auto [width, height] = GridOf(picture);
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "absl/status/status.h"
#include "render/math/vec.h"
#include "render/scene/camera.h"
#include "render/scene/content_hash.h"
#include "render/scene/scene_limits.h"

namespace penumbra {

// Pixels x … x + width − 1 of rows y … y + height − 1; row 0 is the picture's top.
struct PixelRect {
  uint32_t x = 0;
  uint32_t y = 0;
  uint32_t width = 0;
  uint32_t height = 0;

  friend bool operator==(const PixelRect&, const PixelRect&) = default;

  bool empty() const { return width == 0 || height == 0; }
};

// What a camera sees: through each pixel's centre the nearest surface, whichever side it shows.
struct PicturePixels {
  Camera camera;
  uint32_t width = 0;  // of the whole picture
  uint32_t height = 0;
  PixelRect crop;   // the part that is wanted, a deep zoom for instance; empty: all of it
  PixelRect first;  // where to begin, somewhere in the part; empty: in its middle

  friend bool operator==(const PicturePixels&, const PicturePixels&) = default;

  // `crop`, or all of the picture.
  PixelRect part() const { return crop.empty() ? PixelRect{0, 0, width, height} : crop; }
  double aspect() const { return static_cast<double>(width) / height; }
};

// The texels of an instance's surface in the unit square of its mesh's uvs: row 0 is at v = 0.
struct LightmapTexels {
  std::string instance_id;
  uint32_t width = 0;
  uint32_t height = 0;

  friend bool operator==(const LightmapTexels&, const LightmapTexels&) = default;
};

struct SurfacePoint {
  Vec3 position{0.0f};
  Vec3 normal{0, 1, 0};  // to the side that is lit; any length > 0

  friend bool operator==(const SurfacePoint&, const SurfacePoint&) = default;
};

// Points that somebody made: light probes, or texels of a layout of their own.
struct GivenPoints {
  std::shared_ptr<const std::vector<SurfacePoint>> points;  // null: none

  // Of the same points.
  friend bool operator==(const GivenPoints& a, const GivenPoints& b);

  size_t size() const { return points ? points->size() : 0; }
};

using PointReceiver = std::variant<PicturePixels, LightmapTexels, GivenPoints>;

// A message of 1 MiB has room for them, with all the rest of a request.
inline constexpr size_t kMaxGivenPoints = 32'768;

struct GridExtent {
  uint32_t width, height;
};

// How many points there are, or may be: of a picture those of its part, of given points one row.
GridExtent GridOf(const PointReceiver& receiver);

// Whether the receiver can be, whatever the scene.
//
// Errors  kInvalidArgument, the field named from "picture", "lightmap" or "given" on: a camera's,
//         NON_FINITE, OUT_OF_BOUNDS, RANGE, BAD_ID; kResourceExhausted QUOTA_TEXELS, QUOTA_POINTS:
//         too many
absl::Status Check(const PointReceiver& receiver, const SceneLimits& limits = {});

// The same for equal receivers.
ContentHash HashOf(const PointReceiver& receiver);

}  // namespace penumbra
