// The penumbra behind a straight edge: as an artifact tells it, and as light samples do.
#pragma once

#include <memory>
#include <optional>

#include "render/artifact/artifact.h"
#include "render/scene/area_light.h"
#include "render/scene/scene.h"

namespace penumbra::testing {

// A sheet `height` over a floor, which ends along a line through the origin, at right angles to the
// direction (cos angle, 0, sin angle) that points out of its shadow.
struct StraightEdge {
  AreaLight light;
  double height = 1;
  double angle = 0;

  std::shared_ptr<const Scene> MakeScene() const;
};

// How far apart along the floor, across the edge, the places are that get a tenth and nine tenths
// of the light.
//
// By the artifact, of 5000 places from 2.5 m within the shadow to 2.5 m out of it; nullopt: none of
// them are such.
std::optional<double> PenumbraWidth(const StraightEdge& edge, const Artifact& artifact);
// By the line through 4096 points of the light and the edge: where it meets the floor, the point
// appears. Shares of them are shares of the light.
double TruePenumbraWidth(const StraightEdge& edge);

}  // namespace penumbra::testing
