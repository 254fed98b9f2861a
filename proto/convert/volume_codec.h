// Shadow volumes in parts that are named by what is in them, so that what stays as it is need not
// be sent again.
//
//   for (const VolumePartPlan& plan : PartsOf(volume)) {   // the head first
//     if (!has(plan.name)) Send(encoder.Encode(volume, plan));
//   }
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "penumbra/v1/artifact.pb.h"
#include "proto/convert/plane_codec.h"
#include "render/artifact/shadow_volume_mesh.h"

namespace penumbra {

// Samples. A tile of depths takes 16 KB at most.
inline constexpr uint32_t kVolumeTileSide = 64;
// Of a part: 64 KB of vertices, before they are packed.
inline constexpr uint32_t kMaxPartVertices = 4096, kMaxPartTriangles = 4096;
inline constexpr size_t kPartNameBytes = 16;

// What a part has in it.
struct VolumePartPlan {
  enum class Content : uint8_t { kHead, kDepths, kTriangles };

  std::string name;  // kPartNameBytes of a hash
  Content content = Content::kHead;
  std::vector<std::string> names{};        // of a head: all other parts'
  uint32_t face = 0, column = 0, row = 0;  // of depths
  // Of triangles: of the volume's vertices, and of its indices or its casters'.
  size_t first_vertex = 0, end_vertex = 0, first_index = 0, end_index = 0;
  bool are_casters = false;
};

// All parts, the head first. Triangles are parted where a corner's place says so, and not by their
// number: parts before and after what changed stay as they are.
//
// Cost  that of hashing the volume
std::vector<VolumePartPlan> PartsOf(const ShadowVolume& volume);

// One thread at a time.
class VolumePartEncoder {
 public:
  // plan  one of PartsOf(`volume`)
  v1::VolumePart Encode(const ShadowVolume& volume, const VolumePartPlan& plan);

 private:
  void EncodeFloats(const std::vector<float>& floats, v1::FloatPlane& plane);

  PlanePacker packer_;
  std::vector<char> plane_;
};

// How many tiles of depths there are along a side of so many samples.
uint32_t VolumeTilesAlong(uint32_t samples);

}  // namespace penumbra
