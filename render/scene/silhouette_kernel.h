// Telling which edges lie on the outline, compiled for several instruction sets and chosen when
// first called.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "render/scene/silhouette_edges.h"

namespace penumbra {

// Edges of a cluster, and clusters of one parent: a vector of the widest instruction set. Arrays
// are padded to a multiple of it.
inline constexpr size_t kClusterEdges = 16;

// What rounding may add to a height over a face's plane, as a part of the viewpoint's distance.
inline constexpr float kFacingSlack = 1e-5f;

// Appends those of `count` edges from `first` on whose left and right face differ in facing.
void SelectSharedEdges(const EdgeArrays& edges, size_t first, size_t count,
                       const float (&viewpoint)[4], SilhouetteList& list);

// The same of all edges, but for clusters all of whose faces must face one way.
void SelectByClusters(const EdgeArrays& edges, std::span<const ClusterLevel> levels,
                      const float (&viewpoint)[4], SilhouetteList& list);

// Appends the numbers of those edges of which, seen from anywhere within `radius` of `viewpoint`,
// not both faces always face the same way.
void SelectSometimes(const EdgeArrays& edges, size_t count, std::span<const ClusterLevel> levels,
                     const float (&viewpoint)[4], float radius, std::vector<uint32_t>& found);

// Appends all of `count` edges with the facing of their left face.
void AppendBorderEdges(const EdgeArrays& edges, size_t count, const float (&viewpoint)[4],
                       SilhouetteList& list);

}  // namespace penumbra
