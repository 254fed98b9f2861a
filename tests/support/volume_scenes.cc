#include "tests/support/volume_scenes.h"

#include <array>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>
#include <numbers>
#include <utility>

#include "tests/support/random_scene.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {
namespace {

void Append(MeshGeometry& mesh, const MeshGeometry& part, Vec3 at, float scale) {
  const auto first = static_cast<uint32_t>(mesh.positions.size());
  for (const Vec3& p : part.positions) mesh.positions.push_back(at + scale * p);
  for (const uint32_t index : part.indices) mesh.indices.push_back(first + index);
}

// Around the z axis, radii 1 and `tube`.
MeshGeometry Ring(int around, int across, float tube) {
  MeshGeometry ring;
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < across; ++j) {
      const float u = 2 * std::numbers::pi_v<float> * static_cast<float>(i) / around;
      const float v = 2 * std::numbers::pi_v<float> * static_cast<float>(j) / across;
      const float r = 1 + tube * std::cos(v);
      ring.positions.emplace_back(r * std::cos(u), r * std::sin(u), tube * std::sin(v));
      const auto at = [&](int a, int b) {
        return static_cast<uint32_t>((a % around) * across + b % across);
      };
      ring.indices.insert(ring.indices.end(), {at(i, j), at(i + 1, j), at(i, j + 1), at(i, j + 1),
                                               at(i + 1, j), at(i + 1, j + 1)});
    }
  }
  return ring;
}

MeshGeometry RingAndBall() {
  MeshGeometry mesh;
  Append(mesh, Ring(30, 20, 0.25f), Vec3(-0.3f, 0.75f, 0), 0.55f);
  Append(mesh, BallGeometry(24, 15), Vec3(0.8f, 0.4f, 0.3f), 0.35f);
  return mesh;
}

// A three-sided stick without ends.
void AddStick(MeshGeometry& mesh, Vec3 from, Vec3 to, float radius) {
  const Vec3 way = glm::normalize(to - from);
  const Vec3 side =
      glm::normalize(glm::cross(way, std::abs(way.y) < 0.9f ? Vec3(0, 1, 0) : Vec3(1, 0, 0)));
  const Vec3 other = glm::cross(way, side);
  const auto first = static_cast<uint32_t>(mesh.positions.size());
  for (int k = 0; k < 3; ++k) {
    const float angle = 2 * std::numbers::pi_v<float> * static_cast<float>(k) / 3;
    const Vec3 out = std::cos(angle) * side + std::sin(angle) * other;
    mesh.positions.push_back(from + radius * out);
    mesh.positions.push_back(to + 0.6f * radius * out);
  }
  for (uint32_t k = 0; k < 3; ++k) {
    const uint32_t a = first + 2 * k, b = first + 2 * ((k + 1) % 3);
    mesh.indices.insert(mesh.indices.end(), {a, b, a + 1, b, b + 1, a + 1});
  }
}

void AddLeaf(MeshGeometry& mesh, Vec3 at, Dice& dice) {
  const Vec3 u = 0.09f * dice.Direction();
  const Vec3 v = 0.09f * glm::normalize(glm::cross(u, dice.Direction()));
  const auto first = static_cast<uint32_t>(mesh.positions.size());
  for (const Vec3& corner : {-u - v, u - v, u + v, v - u}) mesh.positions.push_back(at + corner);
  for (const uint32_t k : {0, 1, 2, 0, 2, 3}) mesh.indices.push_back(first + k);
}

void AddBranch(MeshGeometry& mesh, Vec3 from, Vec3 way, int level, Dice& dice) {
  const float length = glm::length(way);
  AddStick(mesh, from, from + way, 0.12f * length);
  if (level == 0) {
    for (int k = 0; k < 5; ++k) {
      AddLeaf(mesh, from + way + 0.15f * dice.Direction(), dice);
    }
    return;
  }
  for (int k = 0; k < 3; ++k) {
    const Vec3 turned = glm::normalize(glm::normalize(way) + 0.8f * dice.Direction());
    AddBranch(mesh, from + way, 0.68f * length * turned, level - 1, dice);
  }
}

MeshGeometry Tree() {
  MeshGeometry mesh;
  Dice dice(2000);
  AddBranch(mesh, Vec3(0), Vec3(0, 0.55f, 0), 4, dice);
  return mesh;
}

MeshGeometry Towers() {
  MeshGeometry mesh;
  Dice dice(2001);
  for (int k = 0; k < 130; ++k) {
    const float high = dice.Between(0.05f, 0.45f);
    const Vec3 half(dice.Between(0.03f, 0.09f), high, dice.Between(0.03f, 0.09f));
    MeshGeometry box = UnitBoxGeometry();
    for (Vec3& p : box.positions) p *= half;
    const auto row = static_cast<float>(k / 12), column = static_cast<float>(k % 12);
    Append(mesh, box, Vec3(0.2f * column - 1.1f, high, 0.2f * row - 1.0f), 1);
  }
  return mesh;
}

void AddFlake(MeshGeometry& mesh, const MeshGeometry& ball, Vec3 at, float radius, int level) {
  Append(mesh, ball, at, radius);
  if (level == 0) return;
  for (int k = 0; k < 9; ++k) {  // nine ways, evenly
    const float y = 1 - 2 * (static_cast<float>(k) + 0.5f) / 9;
    const float angle = 2.4f * static_cast<float>(k), ring = std::sqrt(1 - y * y);
    const Vec3 way(ring * std::cos(angle), y, ring * std::sin(angle));
    AddFlake(mesh, ball, at + 1.4f * radius * way, 0.4f * radius, level - 1);
  }
}

MeshGeometry Flake() {
  MeshGeometry mesh;
  AddFlake(mesh, BallGeometry(44, 28), Vec3(0, 0.85f, 0), 0.42f, 2);
  return mesh;
}

MeshGeometry Pot() {
  constexpr int kAround = 40, kAcross = 30;
  MeshGeometry pot = BallGeometry(kAround, kAcross);
  for (Vec3& p : pot.positions) {  // a belly and a knob
    const float y = p.y;
    const float wide = 1 - 0.35f * std::max(0.0f, y - 0.4f) + 0.1f * std::cos(6 * y);
    p = Vec3(0.55f * wide * p.x, 0.45f * (y + 1) + 0.1f, 0.55f * wide * p.z);
  }
  MeshGeometry mesh;
  Append(mesh, pot, Vec3(0), 1);
  Append(mesh, Ring(30, 20, 0.22f), Vec3(0.65f, 0.6f, 0), 0.28f);
  return mesh;
}

// With its mirror image and the ground between.
VolumeScene Mirrored(const char* name, MeshGeometry above) {
  const auto mesh = MeshOf(std::move(above));
  SceneDelta delta;
  delta.upsert_instances = {
      {.id = "above", .mesh = mesh},
      {.id = "below",
       .mesh = mesh,
       .world_from_mesh = Affine(Vec3(1, 0, 0), Vec3(0, -1, 0), Vec3(0, 0, 1), Vec3(0))},
      {.id = "ground",
       .mesh = MeshOf(UnitSquareGeometry()),
       .world_from_mesh = Placed(Vec3(0), 1.5f)}};
  return {.name = name,
          .scene = Scene::Empty(name)->Apply(delta).value(),
          .triangles = 2 * mesh->triangle_count() + 2};
}

}  // namespace

std::vector<VolumeScene> VolumeScenes() {
  return {Mirrored("a", RingAndBall()), Mirrored("b", Towers()), Mirrored("c", Flake()),
          Mirrored("d", Pot()), Mirrored("tree", Tree())};
}

Pose Pose::Random(uint64_t seed) {
  Dice dice(seed);
  // Four numbers with a round distribution are a rotation like any other.
  DVec4 q;
  do {
    q = DVec4(dice.Between(-1, 1), dice.Between(-1, 1), dice.Between(-1, 1), dice.Between(-1, 1));
  } while (!(glm::dot(q, q) > 0.01 && glm::dot(q, q) <= 1));
  q = glm::normalize(q);
  const glm::dquat turn(q.w, q.x, q.y, q.z);
  const double apart = glm::radians(55.0);
  return {.eye = turn * DVec3(0, 0, 5),
          .light = turn * (7.0 * DVec3(std::sin(apart), 0, std::cos(apart))),
          .up = turn * DVec3(0, 1, 0)};
}

EyeImage Pose::Image(uint32_t side) const {
  const double near = 0.05;
  const DMat4 view = glm::lookAt(eye, DVec3(0.0), up);
  return {.clip_from_world = glm::perspective(glm::radians(40.0), 1.0, near, 100.0) * view,
          .width = side,
          .height = side,
          .near = near};
}

}  // namespace penumbra::testing
