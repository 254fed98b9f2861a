// What is in the shadow of a light, by its boundary: a mesh made of what one point of the light
// sees, and the depth maps that it takes to close the mesh where an eye's near plane cuts it.
//
//   float visible = Visibility(mesh, point, normal);   // 0 or 1
//   … draw triangles(): a pixel whose ray has met an odd number of a volume's before its surface …
//
// A volume is all that lies behind a surface that every ray of light meets once. Of the surface
// only those parts are in the mesh that do not lie on something that is drawn anyway.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "render/artifact/volume_grid.h"
#include "render/math/vec.h"
#include "render/scene/area_light.h"
#include "render/scene/content_hash.h"

namespace penumbra {

// Of a mesh, all volumes together; a triangle counts as often as it weighs. Half a gigabyte.
inline constexpr size_t kMaxVolumeTriangles = size_t{1} << 24, kMaxVolumeVertices = size_t{1} << 24;

// What one view has seen for a volume.
struct VolumeFace {
  DepthMap map;
  VolumeBorder border = VolumeBorder::kNothing;
};

enum class VolumeKind : uint8_t {
  kReconstructed,  // corners are samples
  kVectorized,     // contours are lines between samples, with walls along the light's rays
  kObject,         // made from an instance's own edges
};

// In the order of the kinds.
inline constexpr std::array<std::string_view, 3> kVolumeKindNames = {"reconstructed", "vectorized",
                                                                     "object"};

// Of all casters, or of one.
struct ShadowVolume {
  std::string instance_id;  // whose; empty: all casters'
  ContentHash content;      // equal for equal volumes: what to send again and what not
  VolumeKind kind = VolumeKind::kReconstructed;
  // What the light sees; none of kObject. Several together see all around, in this order: the first
  // that covers a point tells of it.
  std::vector<VolumeFace> faces;
  // Homogeneous, in world space: w ≥ 0, and 0 infinitely far.
  std::vector<Vec4> vertices;
  // Three a triangle; seen counter-clockwise from the lit side, but for kObject.
  std::vector<uint32_t> indices;
  // Of kObject, one a triangle: what passing from its front to its back adds to the number of
  // surfaces between the light and the place; the other way it takes as much. Empty: 1 each, and
  // since the number is 0 or 1, a bit that any triangle inverts does as well.
  std::vector<int8_t> weights;
  // Of kObject, three a triangle: the caster's own, whichever way they face. The number of surfaces
  // is that of those that the ray of light has met.
  std::vector<uint32_t> caster_indices;

  size_t triangle_count() const { return indices.size() / 3; }
  size_t weighed_triangle_count() const;  // each as often as it weighs
  size_t sample_count() const;            // of all faces
  size_t bytes() const;
};

// Within kMaxVolumeTriangles and kMaxVolumeVertices.
struct ShadowVolumeMesh {
  AreaLight light;  // seen as its centre
  // How far behind the samples of a map the surface is, in pixels' widths.
  float bias_px = 0.25f;
  // What lies in any of them is in shadow. None is null; meshes share those that did not change.
  std::vector<std::shared_ptr<const ShadowVolume>> volumes;
  // Of the places between two samples that see something, the part where an edge was found: much
  // more than 0.1 tells of a scene finer than its map, or of thresholds too low.
  float edge_fraction = 0.0f;

  size_t triangle_count() const;
  size_t sample_count() const;
  size_t bytes() const;
};

// Whether `point` is seen by the light's centre: 1 or 0. Between samples the surface is linear in
// nearness on each of a cell's two triangles, whatever the kind of the mesh; of kObject it is the
// caster itself. Where no map covers the point it is lit. Behind a light that shines from its front
// alone, and where the surface faces away from all of the light: 0.
//
// normal  of length 1
// Cost    O(1) a face; O(triangles) of kObject. For many points VolumeLookup is quicker
float Visibility(const ShadowVolumeMesh& mesh, Vec3 point, Vec3 normal);

// The same with the surfaces ready to be looked up in.
class VolumeLookup {
 public:
  // Refers to `mesh`.
  explicit VolumeLookup(const ShadowVolumeMesh& mesh);

  float Visibility(Vec3 point, Vec3 normal) const;
  // How many volumes hold the point.
  int Depth(DVec3 point) const;

 private:
  struct Surfaces {
    const ShadowVolume* volume;
    std::vector<VolumeGrid> grids;
  };

  const ShadowVolumeMesh& mesh_;
  std::vector<Surfaces> surfaces_;
};

}  // namespace penumbra
