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
// Of a list: 72 KB.
inline constexpr size_t kMaxNamesOfAList = 4096;

// What a part has in it.
struct VolumePartPlan {
  enum class Content : uint8_t { kHead, kNames, kDepths, kTriangles };

  std::string name;  // kPartNameBytes of a hash
  Content content = Content::kHead;
  std::vector<std::string> names{};        // of a head or a list
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

// Names as they are sent: as they are, or where they are many those of lists, which are appended to
// `lists`.
std::vector<std::string> ListNames(const std::vector<std::string>& names,
                                   std::vector<VolumePartPlan>& lists);
// A list of names, whosever it is.
v1::VolumePart EncodeList(const VolumePartPlan& plan);

// Samples of a tile of depths.
struct VolumeTile {
  uint32_t x, y, width, height;
};
VolumeTile VolumeTileAt(const LightView& view, uint32_t column, uint32_t row);

// How many tiles of depths there are along a side of so many samples.
uint32_t VolumeTilesAlong(uint32_t samples);

}  // namespace penumbra
