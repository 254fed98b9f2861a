// The files that a bake writes for one shadow.
//
//   NAME.exr   of a texture: row 0 at v = 0; channels R, G, B (reflected radiance), count (visible
//              light samples) and inside (1: the texel lies on the receiver, 0: it repeats one
//              nearby, or is 0)
//              of points: the same, row 0 being a picture's top or a lightmap's v = 0; R, G, B are
//              what a white surface would reflect, and inside is 1 where there is a surface
//              of a layered attenuation map: a deep file (client/display/deep_exr.h)
//   NAME.png   the radiance times an exposure, clipped at 1, as sRGB; where there is none, how much
//              of the light is visible; of a layered attenuation map that of each pixel's nearest
//              layer, of its faces one below the other. The exposure, if none is given, makes the
//              brightest channel of all texels 1; of points' radiance it is SuggestExposure(), and
//              a background is shown where they have no surface
//   NAME.json  all that is needed to compute the counts again by other means
//
// Of a shadow volume mesh NAME.exr and NAME.png are there where it has depth maps, and the boundary
// is written as NAME.glb, NAME.ply and NAME.obj (client/cli/volume_files.h).
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
  std::optional<float> exposure;  // absent: chosen for the PNG
  double wall_ms = 0.0;           // from asking for the artifact to having it
};

// Of the files that are written: "exr", "png", …
std::vector<std::string> ExtensionsOf(const ArtifactPayload& payload);

// The JSON's text. `exposure` is the one that the PNG was made with.
std::string BakeJson(const BakeRecord& record, float exposure);

// Writes the files into `folder` and returns their names.
//
// Errors  kUnavailable: cannot be written
absl::StatusOr<std::vector<std::string>> WriteBake(const BakeRecord& record,
                                                   const std::filesystem::path& folder);

}  // namespace penumbra
