#include "deploy/scenes/atelier.h"

#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "deploy/scenes/glb_writer.h"
#include "deploy/scenes/leaf_image.h"
#include "deploy/scenes/shapes.h"

namespace penumbra::sample {
namespace {

constexpr int kSegments = 40;
constexpr float kTableTop = 0.76f;

MeshGeometry Table() {
  MeshGeometry table = Box({-0.8f, kTableTop - 0.04f, -0.42f}, {0.8f, kTableTop, 0.42f});
  Append(table, Box({-0.7f, 0.64f, -0.34f}, {0.7f, kTableTop - 0.04f, 0.34f}));
  for (const float x : {-0.7f, 0.7f}) {
    for (const float z : {-0.33f, 0.33f}) {
      Append(table, Bar({x, kTableTop - 0.04f, z}, {x, 0.0f, z}, Vec2(0.07f), Vec2(0.04f)));
    }
  }
  return table;
}

// Walls of about a centimetre; the inside goes down again to a floor in the foot.
MeshGeometry Vase() {
  const Vec2 profile[] = {{0.0f, 0.0f},     {0.075f, 0.0f},   {0.08f, 0.012f},  {0.065f, 0.03f},
                          {0.105f, 0.11f},  {0.135f, 0.19f},  {0.115f, 0.275f}, {0.06f, 0.345f},
                          {0.048f, 0.385f}, {0.075f, 0.425f}, {0.07f, 0.43f},   {0.04f, 0.385f},
                          {0.05f, 0.34f},   {0.1f, 0.27f},    {0.12f, 0.19f},   {0.07f, 0.06f},
                          {0.0f, 0.045f}};
  return TurnedSmooth(profile, 2, kSegments);
}

MeshGeometry Stand() {
  const Vec2 profile[] = {{0.0f, 0.0f},   {0.2f, 0.0f},   {0.2f, 0.0f},   {0.2f, 0.06f},
                          {0.2f, 0.06f},  {0.15f, 0.06f}, {0.15f, 0.06f}, {0.13f, 0.78f},
                          {0.13f, 0.78f}, {0.18f, 0.78f}, {0.18f, 0.78f}, {0.18f, 0.82f},
                          {0.18f, 0.82f}, {0.0f, 0.82f}};
  return Turned(profile, kSegments);
}

// A folding screen of two panels of slats that lean at a right angle.
MeshGeometry Screen() {
  constexpr float kHeight = 1.75f, kWidth = 0.62f;
  MeshGeometry screen;
  for (const Vec3 along : {Vec3(0.94f, 0, 0.34f), Vec3(-0.94f, 0, 0.34f)}) {
    const auto upright = [&](float s, float size, float bottom) {
      const Vec3 foot = s * along;
      Append(screen, Bar(foot + Vec3(0, bottom, 0), foot + Vec3(0, kHeight, 0), {size, 0.03f},
                         {size, 0.03f}, along));
    };
    upright(0.03f, 0.04f, 0.0f);
    upright(kWidth, 0.04f, 0.0f);
    for (int i = 1; i < 8; ++i) upright(0.03f + (kWidth - 0.03f) * i / 8.0f, 0.02f, 0.16f);
    for (const float y : {0.16f, 0.9f, kHeight - 0.04f}) {
      Append(screen, Bar(0.03f * along + Vec3(0, y, 0), kWidth * along + Vec3(0, y, 0),
                         {0.04f, 0.025f}, {0.04f, 0.025f}, {0, 1, 0}));
    }
  }
  return screen;
}

// Faces +z.
MeshGeometry Chair() {
  MeshGeometry chair;
  constexpr float kSeat = 0.45f, kBack = 0.92f, kHalf = 0.21f;
  for (const float x : {-kHalf, kHalf}) {
    Append(chair, Bar({x, 0.002f, 0.2f}, {x, kSeat, 0.19f}, Vec2(0.03f), Vec2(0.035f)));
    Append(chair, Bar({x, 0.002f, -0.23f}, {x, kSeat, -0.19f}, Vec2(0.03f), Vec2(0.035f)));
    Append(chair, Bar({x, kSeat, -0.19f}, {x, kBack, -0.28f}, Vec2(0.035f), Vec2(0.025f)));
    Append(chair,
           Bar({x, kSeat - 0.03f, -0.19f}, {x, kSeat - 0.03f, 0.19f}, Vec2(0.03f), Vec2(0.03f)));
  }
  for (int i = 0; i < 7; ++i) {
    const float z = -0.18f + 0.063f * static_cast<float>(i);
    Append(chair, Bar({-0.23f, kSeat, z}, {0.23f, kSeat, z}, {0.016f, 0.042f}, {0.016f, 0.042f},
                      {0, 1, 0}));
  }
  for (int i = 0; i < 4; ++i) {
    const float t = 0.25f + 0.23f * static_cast<float>(i);
    const Vec3 at(0.0f, kSeat + t * (kBack - kSeat), -0.19f - 0.09f * t);
    Append(chair, Bar(at - Vec3(kHalf, 0, 0), at + Vec3(kHalf, 0, 0), {0.05f, 0.014f},
                      {0.05f, 0.014f}, {0, 1, 0}));
  }
  return chair;
}

MeshGeometry Pot() {
  const Vec2 profile[] = {{0.0f, 0.0f},    {0.13f, 0.0f},  {0.13f, 0.0f},  {0.175f, 0.27f},
                          {0.175f, 0.27f}, {0.19f, 0.27f}, {0.19f, 0.27f}, {0.19f, 0.32f},
                          {0.19f, 0.32f},  {0.16f, 0.32f}, {0.16f, 0.32f}, {0.155f, 0.28f},
                          {0.155f, 0.28f}, {0.0f, 0.29f}};
  return Turned(profile, kSegments);
}

MeshGeometry Leaves() {
  MeshGeometry leaves;
  for (int i = 0; i < 15; ++i) {
    // The golden angle keeps neighbours apart; inner leaves stand upright.
    const float azimuth = 2.39996f * static_cast<float>(i);
    const float inner = 1.0f - static_cast<float>(i) / 15.0f;
    Append(leaves, LeafCard({.root = {0.05f * std::cos(azimuth), 0.28f, 0.05f * std::sin(azimuth)},
                             .azimuth = azimuth,
                             .rise = 1.15f + 0.4f * inner,
                             .droop = 1.5f - 0.7f * inner,
                             .length = 0.62f + 0.28f * inner,
                             .width = 0.24f},
                            6));
  }
  return leaves;
}

MeshGeometry LanternFoot() {
  const Vec2 profile[] = {{0.0f, 0.0f},     {0.055f, 0.0f},   {0.055f, 0.0f},
                          {0.055f, 0.012f}, {0.055f, 0.012f}, {0.012f, 0.02f},
                          {0.01f, 0.12f},   {0.03f, 0.128f},  {0.0f, 0.128f}};
  return Turned(profile, 24);
}

// Turns the node's +z into `direction`, its +x staying level.
Node Aimed(Node node, DVec3 direction) {
  direction = glm::normalize(direction);
  node.turn = std::atan2(direction.x, direction.z);
  node.pitch = -std::asin(direction.y);
  return node;
}

class Atelier {
 public:
  std::vector<uint8_t> Build() {
    Room();
    Furniture();
    StillLife();
    Plant();
    Lights();
    const DVec3 eye(0.55, 1.6, 3.7), target(0.02, 0.72, -0.5);
    glb_.AddNode(Aimed({.name = "camera",
                        .camera = glb_.AddCamera(40.0 * std::numbers::pi / 180.0),
                        .translation = eye},
                       eye - target));
    return glb_.Bytes();
  }

 private:
  void Add(Node node, const MeshGeometry& geometry, const Material& material) {
    node.mesh = glb_.AddMesh(material.name, geometry, glb_.AddMaterial(material));
    glb_.AddNode(node);
  }

  void Room() {
    Add({.name = "floor"}, Quad({-3, 0, 4}, {3, 0, 4}, {3, 0, -2}, {-3, 0, -2}),
        {.name = "floorboards", .color = {0.62, 0.54, 0.45}});
    Add({.name = "wall"}, Quad({-3, 0, -2}, {3, 0, -2}, {3, 3, -2}, {-3, 3, -2}),
        {.name = "plaster", .color = {0.72, 0.71, 0.66}});
  }

  void Furniture() {
    Add({.name = "table", .translation = {0.0, 0.0, -0.5}}, Table(),
        {.name = "walnut", .color = {0.30, 0.17, 0.09}});
    Add({.name = "screen", .translation = {-1.42, 0.0, -0.75}, .turn = 0.6}, Screen(),
        {.name = "bamboo", .color = {0.66, 0.50, 0.28}});
    Add({.name = "chair", .translation = {0.95, 0.0, 0.75}, .turn = -2.3}, Chair(),
        {.name = "beech", .color = {0.60, 0.36, 0.20}});
    Add({.name = "stand", .translation = {1.3, 0.0, -0.75}}, Stand(),
        {.name = "stone", .color = {0.55, 0.55, 0.53}});
  }

  void StillLife() {
    Add({.name = "vase", .translation = {-0.3, kTableTop, -0.52}}, Vase(),
        {.name = "glaze", .color = {0.10, 0.27, 0.33}});
    const MeshGeometry ball = Ball(0.2f, 20, kSegments);
    Add({.name = "ball", .translation = {1.3, 1.02, -0.75}}, ball,
        {.name = "ivory", .color = {0.80, 0.74, 0.62}});
    const int fruit =
        glb_.AddMesh("fruit", Ball(0.045f, 14, 24),
                     glb_.AddMaterial({.name = "fruit", .color = {0.72, 0.22, 0.07}}));
    const DVec3 places[] = {{0.08, 0.0, -0.34}, {0.17, 0.0, -0.39}, {0.105, 0.0, -0.44}};
    for (int i = 0; i < 3; ++i) {
      glb_.AddNode({.name = "fruit-" + std::to_string(i + 1),
                    .mesh = fruit,
                    .translation = places[i] + DVec3(0.0, kTableTop + 0.045, 0.0)});
    }
  }

  void Plant() {
    Add({.name = "pot", .translation = {-0.85, 0.0, 0.55}}, Pot(),
        {.name = "terracotta", .color = {0.55, 0.24, 0.14}});
    const int image = glb_.AddImage(LeafPng());
    Add({.name = "leaves", .translation = {-0.85, 0.0, 0.55}}, Leaves(),
        {.name = "fern", .alpha_image = image, .two_sided = true});
  }

  void Lights() {
    const DVec3 corner(-1.9, 2.5, 1.3);
    Add(Aimed({.name = "softbox", .translation = corner}, DVec3(0.2, 0.4, -0.7) - corner),
        Quad({-0.5f, -0.4f, 0}, {0.5f, -0.4f, 0}, {0.5f, 0.4f, 0}, {-0.5f, 0.4f, 0}),
        {.name = "softbox", .color = DVec3(1.0), .emission = {20.0, 18.4, 16.2}});
    const DVec3 foot(0.52, kTableTop, -0.58);
    Add({.name = "lantern-foot", .translation = foot}, LanternFoot(),
        {.name = "brass", .color = {0.55, 0.40, 0.15}});
    Add({.name = "lantern", .translation = foot + DVec3(0.0, 0.18, 0.0)}, Ball(0.05f, 16, 32),
        {.name = "flame", .color = DVec3(1.0), .emission = {9.0, 5.4, 2.4}});
  }

  GlbWriter glb_;
};

}  // namespace

std::vector<uint8_t> AtelierGlb() { return Atelier().Build(); }

}  // namespace penumbra::sample
