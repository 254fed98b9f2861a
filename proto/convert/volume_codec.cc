#include "proto/convert/volume_codec.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <iterator>
#include <span>
#include <utility>

#include "proto/convert/float_plane.h"
#include "proto/convert/geometry_convert.h"
#include "proto/convert/view_convert.h"

namespace penumbra {
namespace {

// A part ends after one in 256 triangles, told by its first corner's place, but not before the
// 64th.
constexpr uint32_t kEndMask = 255;
constexpr size_t kLeastTriangles = 64;

std::string NameOf(const std::string& content) {
  const ContentHash hash = Sha256(std::as_bytes(std::span(content)));
  return {reinterpret_cast<const char*>(hash.bytes.data()), kPartNameBytes};
}

template <typename T>
void Append(const T* values, size_t count, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(values), count * sizeof(T));
}

std::vector<float> DepthsOf(const DepthMap& map, uint32_t column, uint32_t row) {
  const VolumeTile rect = VolumeTileAt(map.view, column, row);
  std::vector<float> depths;
  depths.reserve(size_t{rect.width} * rect.height);
  for (uint32_t j = 0; j < rect.height; ++j) {
    const float* const first = &map.depths[size_t{rect.y + j} * map.view.width + rect.x];
    depths.insert(depths.end(), first, first + rect.width);
  }
  return depths;
}

void AppendDepths(const ShadowVolume& volume, std::vector<VolumePartPlan>& parts) {
  for (uint32_t face = 0; face < volume.faces.size(); ++face) {
    const DepthMap& map = volume.faces[face].map;
    for (uint32_t row = 0; row < VolumeTilesAlong(map.view.height); ++row) {
      for (uint32_t column = 0; column < VolumeTilesAlong(map.view.width); ++column) {
        const uint32_t place[] = {face, column, row};
        std::string content = "depths";
        Append(place, 3, content);
        const std::vector<float> depths = DepthsOf(map, column, row);
        Append(depths.data(), depths.size(), content);
        parts.push_back({.name = NameOf(content),
                         .content = VolumePartPlan::Content::kDepths,
                         .face = face,
                         .column = column,
                         .row = row});
      }
    }
  }
}

// Whether a part ends at a vertex: the same for the same place, wherever it is in the mesh.
bool EndsAt(const Vec4& vertex) {
  uint32_t mixed = 0;
  for (int c = 0; c < 4; ++c) mixed = (mixed ^ std::bit_cast<uint32_t>(vertex[c])) * 0x9E3779B1u;
  return (mixed >> 16 & kEndMask) == 0;
}

// Parts a volume's vertices and triangles.
class TriangleParts {
 public:
  TriangleParts(const ShadowVolume& volume, std::vector<VolumePartPlan>& parts)
      : volume_(volume), parts_(parts) {}

  // Of `indices` all triangles.
  void Add(bool are_casters) {
    const auto& indices = are_casters ? volume_.caster_indices : volume_.indices;
    Begin(are_casters, 0);
    for (size_t i = 0; i + 2 < indices.size(); i += 3) {
      const size_t needed = size_t{1} + std::max({indices[i], indices[i + 1], indices[i + 2]});
      if (needed > part_.first_vertex + kMaxPartVertices) {
        End();
        AddVerticesAlone(needed);
      }
      part_.end_vertex = std::max(part_.end_vertex, needed);
      part_.end_index = i + 3;
      const size_t count = (part_.end_index - part_.first_index) / 3;
      const bool may_end = count >= kLeastTriangles && EndsAt(volume_.vertices[indices[i]]);
      if (may_end || count == kMaxPartTriangles) End();
    }
    End();
  }

  // Those that no triangle has.
  void AddRestOfVertices() {
    Begin(false, volume_.indices.size());
    while (part_.end_vertex < volume_.vertices.size()) {
      part_.end_vertex = std::min(volume_.vertices.size(), part_.first_vertex + kMaxPartVertices);
      End();
    }
  }

 private:
  void Begin(bool are_casters, size_t first_index) {
    part_ = {.name = {},
             .content = VolumePartPlan::Content::kTriangles,
             .first_vertex = part_.end_vertex,
             .end_vertex = part_.end_vertex,
             .first_index = first_index,
             .end_index = first_index,
             .are_casters = are_casters};
  }

  // Until what is left to come fits into one part.
  void AddVerticesAlone(size_t needed) {
    while (needed > part_.first_vertex + kMaxPartVertices) {
      part_.end_vertex = part_.first_vertex + kMaxPartVertices;
      End();
    }
  }

  void End() {
    if (part_.end_vertex == part_.first_vertex && part_.end_index == part_.first_index) return;
    part_.name = NameOf(Content());
    parts_.push_back(part_);
    Begin(part_.are_casters, part_.end_index);
  }

  // All that is sent.
  std::string Content() const {
    std::string content = part_.are_casters ? "casters" : "triangles";
    const size_t vertices = part_.end_vertex - part_.first_vertex;
    Append(&vertices, 1, content);
    Append(volume_.vertices.data() + part_.first_vertex, vertices, content);
    const auto& indices = part_.are_casters ? volume_.caster_indices : volume_.indices;
    for (size_t i = part_.first_index; i < part_.end_index; ++i) {
      const auto corner = static_cast<uint32_t>(part_.end_vertex - indices[i]);
      Append(&corner, 1, content);
    }
    if (!part_.are_casters && !volume_.weights.empty()) {
      Append(volume_.weights.data() + part_.first_index / 3,
             (part_.end_index - part_.first_index) / 3, content);
    }
    return content;
  }

  const ShadowVolume& volume_;
  std::vector<VolumePartPlan>& parts_;
  VolumePartPlan part_;
};

v1::VolumeHead HeadOf(const ShadowVolume& volume, const std::vector<std::string>& names) {
  v1::VolumeHead head;
  head.set_instance_id(volume.instance_id);
  head.set_content(ToProto(volume.content));
  // The protocol counts from 1 what is listed in the same order here.
  head.set_kind(static_cast<v1::VolumeKind>(static_cast<int>(volume.kind) + 1));
  for (const VolumeFace& face : volume.faces) {
    v1::VolumeFace& added = *head.add_faces();
    *added.mutable_view() = ToProto(face.map.view);
    added.set_border(static_cast<v1::VolumeBorder>(static_cast<int>(face.border) + 1));
  }
  for (const std::string& name : names) head.add_parts(name);
  return head;
}

}  // namespace

VolumeTile VolumeTileAt(const LightView& view, uint32_t column, uint32_t row) {
  const uint32_t x = kVolumeTileSide * column, y = kVolumeTileSide * row;
  return {x, y, std::min(kVolumeTileSide, view.width - x),
          std::min(kVolumeTileSide, view.height - y)};
}

std::vector<std::string> ListNames(const std::vector<std::string>& names,
                                   std::vector<VolumePartPlan>& lists) {
  if (names.size() <= kMaxNamesOfAList) return names;
  std::vector<std::string> of_lists;
  for (size_t first = 0; first < names.size(); first += kMaxNamesOfAList) {
    const size_t end = std::min(names.size(), first + kMaxNamesOfAList);
    VolumePartPlan list{.content = VolumePartPlan::Content::kNames};
    std::string content = "names";
    for (size_t i = first; i < end; ++i) {
      list.names.push_back(names[i]);
      content += names[i];
    }
    list.name = NameOf(content);
    of_lists.push_back(list.name);
    lists.push_back(std::move(list));
  }
  return of_lists;
}

v1::VolumePart EncodeList(const VolumePartPlan& plan) {
  v1::VolumePart part;
  part.set_name(plan.name);
  for (const std::string& name : plan.names) part.mutable_names()->add_names(name);
  return part;
}

uint32_t VolumeTilesAlong(uint32_t samples) {
  return (samples + kVolumeTileSide - 1) / kVolumeTileSide;
}

std::vector<VolumePartPlan> PartsOf(const ShadowVolume& volume) {
  std::vector<VolumePartPlan> content;
  AppendDepths(volume, content);
  TriangleParts triangles(volume, content);
  triangles.Add(false);
  triangles.Add(true);
  triangles.AddRestOfVertices();
  std::vector<std::string> names;
  for (const VolumePartPlan& part : content) names.push_back(part.name);
  std::vector<VolumePartPlan> parts(1);
  std::vector<std::string> listed = ListNames(names, parts);
  parts.front().name = NameOf("head" + HeadOf(volume, listed).SerializeAsString());
  parts.front().names = std::move(listed);
  std::ranges::move(content, std::back_inserter(parts));
  return parts;
}

void VolumePartEncoder::EncodeFloats(const std::vector<float>& floats, v1::FloatPlane& plane) {
  ToPlane(floats, plane_);
  plane.set_codec(packer_.Pack(plane_, *plane.mutable_packed()));
}

v1::VolumePart VolumePartEncoder::Encode(const ShadowVolume& volume, const VolumePartPlan& plan) {
  if (plan.content == VolumePartPlan::Content::kNames) return EncodeList(plan);
  v1::VolumePart part;
  part.set_name(plan.name);
  if (plan.content == VolumePartPlan::Content::kHead) {
    *part.mutable_head() = HeadOf(volume, plan.names);
    return part;
  }
  if (plan.content == VolumePartPlan::Content::kDepths) {
    v1::VolumeDepths& depths = *part.mutable_depths();
    depths.set_face(plan.face);
    depths.set_column(plan.column);
    depths.set_row(plan.row);
    EncodeFloats(DepthsOf(volume.faces[plan.face].map, plan.column, plan.row),
                 *depths.mutable_depths());
    return part;
  }
  v1::VolumeTriangles& triangles = *part.mutable_triangles();
  triangles.set_vertex_count(static_cast<uint32_t>(plan.end_vertex - plan.first_vertex));
  if (triangles.vertex_count() > 0) {
    std::vector<float> numbers;
    for (int c = 0; c < 4; ++c) {
      for (size_t i = plan.first_vertex; i < plan.end_vertex; ++i) {
        numbers.push_back(volume.vertices[i][c]);
      }
    }
    EncodeFloats(numbers, *triangles.mutable_vertices());
  }
  const auto& indices = plan.are_casters ? volume.caster_indices : volume.indices;
  for (size_t i = plan.first_index; i < plan.end_index; ++i) {
    triangles.add_corners(static_cast<uint32_t>(plan.end_vertex - indices[i]));
  }
  for (size_t t = plan.first_index / 3;
       !plan.are_casters && !volume.weights.empty() && t < plan.end_index / 3; ++t) {
    triangles.add_weights(volume.weights[t]);
  }
  triangles.set_are_the_casters(plan.are_casters);
  return part;
}

}  // namespace penumbra
