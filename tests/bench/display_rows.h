// What it costs to draw with layers, a part of the suite layered_attenuation.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "render/artifact/attenuation_ldi.h"
#include "render/scene/scene.h"
#include "tests/bench/bench.h"

namespace penumbra::bench {

// Pictures of 512×512 pixels with `ldi` of the scene's only light. The peer is the same renderer
// with a plain shadow map: the nearest layer of each pixel, of which one is looked at a point.
std::vector<Row> DisplayRows(const std::string& name, const Scene& scene, const AttenuationLdi& ldi,
                             const BenchOptions& options);

}  // namespace penumbra::bench
