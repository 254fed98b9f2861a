// How wide a light is to the shadow of an edge.
//
//   const LightWidth width(light, view);
//   double penumbra = width.Along(at, across) * (nearness_of_blocker - nearness_of_receiver);
#pragma once

#include <array>

#include "render/artifact/light_view.h"
#include "render/math/vec.h"
#include "render/scene/area_light.h"

namespace penumbra {

// An edge at nearness r₁ (PlaneOnImage) casts a shadow onto a surface at r₂. Seen from another
// point of the light, e away in the view's frame, the shadow of what is at w on the image moves by
//
//   (w · e.z − e.xy) · (r₁ − r₂)
//
// which of a distant light is e · (r₁ − r₂) for slopes e. How wide a penumbra is, is told by the
// variance of such shifts across the edge. A straight ramp of width W has the variance W² / 12, and
// so has a rectangle of that width; a disk of radius R has R² / 4, as a ramp √3 R wide. Variances
// of a rectangle's two edges add, so that
//
//   W(w, d)² = Σ ((w · a.z − a.xy) · d)²
//
// over the axes a: a rectangle's edges; √3 R along two or, of a sphere, three directions.
//
// Units  metres; of distant lights slopes
class LightWidth {
 public:
  // All zero: points and spots, which cast hard shadows.
  LightWidth(const AreaLight& light, const LightView& view);

  // W at `at` on the image, across an edge at right angles to `direction`, of length 1; where that
  // is 0, the mean over all directions.
  double Along(DVec2 at, DVec2 direction) const;

  const std::array<DVec3, 3>& axes() const { return axes_; }

 private:
  bool from_infinity_;
  std::array<DVec3, 3> axes_{};
};

}  // namespace penumbra
