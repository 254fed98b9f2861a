// Views just large enough for what they are to see.
//
//   if (const auto view = ViewFrom(face, sample, boxes, pitch)) …
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "render/light_view/light_face.h"
#include "render/scene/light_sample.h"

namespace penumbra {

// The part of its far depth below which a view sees nothing: a light's own surface is there. As
// much as the reference's rays stop short of the light.
inline constexpr double kNearFraction = 0x1.0p-16;

// The most pixels along a side of a view; as much as a receiver's grid, and as llvmpipe's textures.
inline constexpr uint32_t kMaxViewSide = 16384;

// The view of `face` from `sample`, just large enough for `boxes`; nullopt where none of them is to
// be seen. What the face's window shows from the light's centre is in it, but for what is so near
// to a light of some size that the view would have to be more than three times as wide or high as
// the window. Near and far are as tight as the boxes allow.
//
// boxes  of what is to be seen, in world space, all within the bounds that `face` is of
// pitch  slope, or metres, a pixel: > 0, or else nullopt. Where the view would have more than
//        kMaxViewSide pixels a side, it has as many and they are larger
std::optional<LightView> ViewFrom(const LightFace& face, const LightSample& sample,
                                  std::span<const Aabb> boxes, double pitch);

// The same from the face's own middle.
std::optional<LightView> CenterView(const LightFace& face, std::span<const Aabb> boxes,
                                    double pitch);

// Those of the view's own pixels that `box` may fill, and one more around; nullopt: none.
std::optional<LightView> PartOf(const LightView& view, const Aabb& box);

}  // namespace penumbra
