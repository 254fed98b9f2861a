// The three files that a bake writes for one light and one receiver.
//
//   NAME.exr   row 0 at v = 0; channels R, G, B (reflected radiance), count (visible light samples)
//              and inside (1: the texel lies on the receiver, 0: it repeats one nearby, or is 0)
//   NAME.png   the radiance times an exposure, clipped at 1, as sRGB
//   NAME.json  all that is needed to compute the counts again by other means
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "render/artifact/artifact.h"

namespace penumbra {

struct BakeRecord {
  const Artifact& artifact;
  std::string scene;              // the file, as it was named
  std::string name;               // of the files, without extension
  std::optional<float> exposure;  // absent: the brightest channel of all texels becomes 1
  double wall_ms = 0.0;           // from asking for the artifact to having it
};

// The JSON's text. `exposure` is the one that the PNG was made with.
std::string BakeJson(const BakeRecord& record, const SoftShadowTexture& texture, float exposure);

// Writes the files into `folder` and returns their names.
//
// Errors  kUnavailable: cannot be written
absl::StatusOr<std::vector<std::string>> WriteBake(const BakeRecord& record,
                                                   const std::filesystem::path& folder);

}  // namespace penumbra
