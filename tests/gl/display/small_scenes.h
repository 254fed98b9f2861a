// Scenes small enough to know every pixel of.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "client/display/picture.h"
#include "render/artifact/artifact.h"
#include "render/scene/camera.h"
#include "render/scene/scene.h"

namespace penumbra {

// The scene after one delta on the empty one; fails the test when it does not commit.
std::shared_ptr<const Scene> SceneOf(const SceneDelta& delta);

// Two triangles over origin + s·u + t·v, with uv = (s, t) and the front u × v.
std::shared_ptr<const Mesh> Quad(Vec3 origin, Vec3 u, Vec3 v);
// The cuboid between two corners, without vertex normals.
std::shared_ptr<const Mesh> Cuboid(Vec3 low, Vec3 high);

// An artifact of `receiver_id` for `light_id` whose counts are given texel by texel.
std::shared_ptr<const Artifact> ArtifactOf(
    const Scene& scene, const std::string& light_id, const std::string& receiver_id,
    uint32_t sample_count, const std::function<uint32_t(uint32_t i, uint32_t j)>& count);

// Where the ray through the centre of pixel (x, y), y from the top, meets the plane through
// `origin` with `normal`; the camera's own matrices are not used.
Vec3 HitPlane(const Camera& camera, const Picture& picture, int x, int y, Vec3 origin, Vec3 normal);

}  // namespace penumbra
