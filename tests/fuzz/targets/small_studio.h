// A small scene for seeds: a floor, a box that casts, a fence with holes, a light of each kind and
// a receiver of each shape.
#pragma once

#include <memory>

#include "render/scene/alpha_mask.h"
#include "render/scene/mesh.h"
#include "render/scene/scene.h"
#include "tests/fuzz/targets/known_blobs.h"

namespace penumbra::fuzzing {

std::shared_ptr<const Mesh> StudioBox();
std::shared_ptr<const Mesh> StudioSquare();
std::shared_ptr<const AlphaMask> StudioMask();

// The three.
KnownBlobs StudioBlobs();

// All of it.
SceneDelta StudioDelta();
// The box somewhere else.
SceneDelta BoxAt(float x);

// What scenes may hold, so little that scripts come to it.
SceneLimits SmallLimits();

}  // namespace penumbra::fuzzing
