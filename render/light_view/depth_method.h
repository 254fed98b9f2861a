// Which way to make a depth map, by what each would cost.
//
//   const CasterSizes casters(scene);
//   if (RasterNs(casters.WorkOf(view)) <= RaysNs(casters.WorkOf(view))) …
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "render/artifact/light_view.h"
#include "render/scene/scene.h"

namespace penumbra {

enum class DepthMethod : uint8_t {
  kAuto,    // the CPU's, whichever is cheaper by the model below
  kRaster,  // triangles drawn by the CPU
  kRays,    // rays by the CPU
  kGl,      // triangles drawn by GL
};

// In the order of the methods.
inline constexpr std::array<std::string_view, 4> kDepthMethodNames = {"auto", "raster", "rays",
                                                                      "gl"};

constexpr std::string_view NameOf(DepthMethod method) {
  return kDepthMethodNames[static_cast<size_t>(method)];
}

// What there is to draw for one view.
struct DepthWork {
  double pixels = 0;
  double casters = 0;           // that may be seen
  double triangles = 0;         // of casters that may be seen, without a mask
  double masked_triangles = 0;  // with one
  double covered = 0;           // pixels of the boxes around casters, each on its own
  double filled = 0;            // pixels of all triangles, by their area, seen from anywhere
  double masked_filled = 0;     // the same of those with a mask
};

// Nanoseconds of one thread that a view takes. They depend on the view and the scene alone, never
// on a clock, so that the choice between them is the same in every run and on every machine:
// sources differ in a few bits, and an artifact must not.
//
// Source  fitted to medians of `penumbra_bench --suite light_view`, whose rows *_vs_model say how
//         well they hold (docs/adr/0009)
double RasterNs(const DepthWork& work);
double RaysNs(const DepthWork& work);

// The casting instances of a scene by size.
class CasterSizes {
 public:
  explicit CasterSizes(const Scene& scene);

  // Cost  O(instances)
  DepthWork WorkOf(const LightView& view) const;

 private:
  struct Caster {
    Aabb box;
    double triangles;
    double area;  // of all of them, in m²
    bool is_masked;
  };
  std::vector<Caster> casters_;
};

}  // namespace penumbra
