#include "tests/gl/display/small_scenes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <utility>

namespace penumbra {

std::shared_ptr<const Scene> SceneOf(const SceneDelta& delta) {
  auto scene = Scene::Empty("test")->Apply(delta);
  EXPECT_TRUE(scene.ok()) << scene.status();
  return scene.ok() ? *scene : Scene::Empty("test");
}

std::shared_ptr<const Mesh> Quad(Vec3 origin, Vec3 u, Vec3 v) {
  MeshGeometry geometry;
  geometry.positions = {origin, origin + u, origin + u + v, origin + v};
  geometry.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  geometry.indices = {0, 1, 2, 0, 2, 3};
  return *Mesh::Create(std::move(geometry));
}

std::shared_ptr<const Mesh> Cuboid(Vec3 low, Vec3 high) {
  MeshGeometry geometry;
  for (int corner = 0; corner < 8; ++corner) {
    geometry.positions.emplace_back((corner & 1) ? high.x : low.x, (corner & 2) ? high.y : low.y,
                                    (corner & 4) ? high.z : low.z);
  }
  const uint32_t faces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  for (const auto& f : faces) {
    geometry.indices.insert(geometry.indices.end(), {f[0], f[1], f[2], f[0], f[2], f[3]});
  }
  return *Mesh::Create(std::move(geometry));
}

std::shared_ptr<const Artifact> ArtifactOf(
    const Scene& scene, const std::string& light_id, const std::string& receiver_id,
    uint32_t sample_count, const std::function<uint32_t(uint32_t i, uint32_t j)>& count) {
  const auto patch = scene.ResolveReceiver(receiver_id);
  const auto light = scene.FindLight(light_id);
  EXPECT_TRUE(patch.ok()) << patch.status();
  EXPECT_NE(light, nullptr);
  if (!patch.ok() || light == nullptr) return nullptr;
  SoftShadowTexture texture;
  texture.receiver = *patch;
  texture.light = *light;
  texture.visibility.width = patch->width;
  texture.visibility.height = patch->height;
  texture.visibility.sample_count = sample_count;
  for (uint32_t j = 0; j < patch->height; ++j) {
    for (uint32_t i = 0; i < patch->width; ++i) {
      texture.visibility.counts.push_back(static_cast<uint16_t>(count(i, j)));
    }
  }
  auto artifact = std::make_shared<Artifact>();
  artifact->header.scene_id = scene.id();
  artifact->header.revision = scene.revision();
  artifact->header.light_id = light_id;
  artifact->header.receiver_id = receiver_id;
  artifact->payload = std::move(texture);
  return artifact;
}

Vec3 HitPlane(const Camera& camera, const Picture& picture, int x, int y, Vec3 origin,
              Vec3 normal) {
  const DVec3 eye(camera.eye);
  const DVec3 forward = glm::normalize(DVec3(camera.target) - eye);
  const DVec3 right = glm::normalize(glm::cross(forward, DVec3(camera.up)));
  const DVec3 up = glm::cross(right, forward);
  const double half_height = std::tan(camera.fov_y_deg * std::numbers::pi / 360);
  const double pixel = 2 * half_height / picture.height;
  const DVec3 ray = forward + (x + 0.5 - 0.5 * picture.width) * pixel * right +
                    (0.5 * picture.height - y - 0.5) * pixel * up;
  const DVec3 n(normal);
  return Vec3(eye + glm::dot(n, DVec3(origin) - eye) / glm::dot(n, ray) * ray);
}

}  // namespace penumbra
