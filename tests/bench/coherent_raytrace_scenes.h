// The scenes that shadows on arbitrary surfaces are measured on: models by other authors, on a
// floor under a rectangular light.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "render/scene/camera.h"
#include "render/scene/scene.h"

namespace penumbra::bench {

struct LitModel {
  std::string name;
  std::shared_ptr<const Scene> scene;
  AreaLight light;
  Camera camera;  // that just holds the model
};

// garden, flower, plants and dragon, those of them that are in the folder PENUMBRA_SCENES: the
// light half as wide as the model and as far above it as it is wide, over the dragon displaced
// towards its head (Agrawala et al. 2000, §6).
std::vector<LitModel> LitModels();

}  // namespace penumbra::bench
