// Telling which edges lie on the outline, compiled for several instruction sets and chosen when
// first called.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "render/scene/silhouette_edges.h"

namespace penumbra {

// What rounding may add to a height over a face's plane, as a part of the viewpoint's distance.
inline constexpr float kFacingSlack = 1e-5f;

// Appends the edges whose left and right face differ in facing.
void SelectSharedEdges(std::span<const EdgeCluster> edges, const float (&viewpoint)[4],
                       SilhouetteList& list);

// Viewpoints near each other: all within `radius` of `center`, and rounding with them.
inline constexpr size_t kGroupViews = 8;
struct ViewGroup {
  float viewpoints[kGroupViews][4];
  size_t count = 0;
  float center[4];
  float radius = 0;
};

// The same for each viewpoint of a group, list by list. All edges are asked about if there are no
// levels.
void SelectForEach(std::span<const EdgeCluster> edges, std::span<const ClusterLevel> levels,
                   const ViewGroup& group, std::span<SilhouetteList> lists);

// Puts those of `count` edges one after another of which, seen from anywhere within `radius` of
// `viewpoint`, not both faces always face the same way. Returns how many they are; `copies` is
// empty before.
size_t CopySometimes(std::span<const EdgeCluster> edges, size_t count,
                     std::span<const ClusterLevel> levels, const float (&viewpoint)[4],
                     float radius, std::vector<EdgeCluster>& copies);

// Appends all of `count` edges with the facing of their face.
void AppendBorderEdges(std::span<const BorderCluster> edges, size_t count,
                       const float (&viewpoint)[4], SilhouetteList& list);

}  // namespace penumbra
