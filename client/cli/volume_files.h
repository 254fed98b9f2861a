// What files show of a shadow volume mesh.
#pragma once

#include <filesystem>

#include "absl/status/status.h"
#include "render/artifact/radiance_format.h"
#include "render/artifact/shadow_texels.h"
#include "render/artifact/shadow_volume_mesh.h"

namespace penumbra {

// Whether there are depth maps, and not so many that an image of them all is too large.
bool HasImages(const ShadowVolumeMesh& mesh);

// How near what the light sees is, grey: 1 the nearest of all, 0 where nothing is; faces one below
// the other. Empty without HasImages().
RadianceTexture PictureOf(const ShadowVolumeMesh& mesh);

// The depths of all faces, one below the other, as the channel depth of an EXR file: metres,
// infinity where nothing is.
absl::Status WriteNumbers(const std::filesystem::path& path, const ShadowVolumeMesh& mesh,
                          const RadianceTexture& picture);

// The boundary as a mesh file: binary glTF (.glb), PLY (.ply) or OBJ (.obj). One object a volume,
// in world space, named by its instance; what goes on without end is cut off at several times the
// size of the scene. Triangles are seen counter-clockwise from the lit side, and are there as often
// as they weigh.
//
// Errors  kUnavailable: cannot be written; kInternal: the exporter failed
absl::Status WriteBoundary(const std::filesystem::path& path, const ShadowVolumeMesh& mesh);

}  // namespace penumbra
