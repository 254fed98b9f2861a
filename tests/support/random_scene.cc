#include "tests/support/random_scene.h"

#include <numbers>
#include <utility>

#include "absl/strings/str_cat.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {
namespace {

std::shared_ptr<const Mesh> Triangles(Dice& dice, int count, float size) {
  MeshGeometry soup;
  for (int t = 0; t < count; ++t) {
    const Vec3 at = dice.InCube(1.5f);
    for (int k = 0; k < 3; ++k) {
      soup.positions.push_back(at + dice.InCube(size));
      soup.indices.push_back(3 * t + k);
    }
  }
  return MeshOf(std::move(soup));
}

// Long and thin, down to a few millionths of their length; some have no area at all.
std::shared_ptr<const Mesh> Slivers(Dice& dice, int count) {
  MeshGeometry slivers;
  for (int t = 0; t < count; ++t) {
    const Vec3 from = dice.InCube(2), along = dice.InCube(2);
    const float width = std::pow(10.0f, dice.Between(-6, -1));
    slivers.positions.insert(slivers.positions.end(),
                             {from, from + along, from + 0.5f * along + width * dice.Direction()});
    const uint32_t i = 3 * t;
    slivers.indices.insert(slivers.indices.end(), {i, i + 1, t % 7 == 0 ? i + 1 : i + 2});
  }
  return MeshOf(std::move(slivers));
}

// A closed ball of radius 1.
std::shared_ptr<const Mesh> Ball(uint32_t rings, uint32_t sectors) {
  MeshGeometry ball;
  for (uint32_t r = 0; r <= rings; ++r) {
    const float polar = std::numbers::pi_v<float> * r / rings;
    for (uint32_t s = 0; s < sectors; ++s) {
      const float azimuth = 2 * std::numbers::pi_v<float> * s / sectors;
      const bool pole = r == 0 || r == rings;
      const float radius = pole ? 0 : std::sin(polar);
      ball.positions.emplace_back(radius * std::cos(azimuth),
                                  r == 0 ? 1 : (r == rings ? -1 : std::cos(polar)),
                                  -radius * std::sin(azimuth));
    }
  }
  const auto vertex = [&](uint32_t r, uint32_t s) { return r * sectors + s % sectors; };
  for (uint32_t r = 0; r < rings; ++r) {
    for (uint32_t s = 0; s < sectors; ++s) {
      const uint32_t a = vertex(r, s), b = vertex(r + 1, s), c = vertex(r + 1, s + 1),
                     d = vertex(r, s + 1);
      if (r + 1 < rings) ball.indices.insert(ball.indices.end(), {a, b, c});
      if (r > 0) ball.indices.insert(ball.indices.end(), {a, c, d});
    }
  }
  return MeshOf(std::move(ball));
}

std::shared_ptr<const AlphaMask> Holes(Dice& dice) {
  const uint32_t width = 1 + dice.Below(9), height = 1 + dice.Below(9);
  std::vector<uint8_t> alpha(width * height);
  for (uint8_t& a : alpha) a = static_cast<uint8_t>(dice.Below(256));
  return AlphaMask::Create(width, height, std::move(alpha)).value();
}

Receiver RandomReceiver(Dice& dice) {
  Parallelogram patch{.origin = dice.InCube(1), .edge_u = {}, .edge_v = {}};
  patch.edge_u = dice.Between(1, 4) * dice.Direction();
  const Vec3 other = dice.Direction();
  const Vec3 across = glm::normalize(glm::cross(patch.edge_u, other));
  patch.edge_v = dice.Between(1, 4) * across + dice.Between(-0.5f, 0.5f) * patch.edge_u;
  patch.origin -= 0.5f * (patch.edge_u + patch.edge_v);
  return {
      .id = "receiver", .shape = patch, .width = 1 + dice.Below(97), .height = 1 + dice.Below(97)};
}

Vec3 SomewhereOn(const AreaLight& light, Vec3 fallback) {
  if (const auto* rectangle = std::get_if<RectangleLight>(&light.shape)) {
    return rectangle->corner + 0.5f * (rectangle->edge_u + rectangle->edge_v);
  }
  if (const auto* disk = std::get_if<DiskLight>(&light.shape)) return disk->center;
  if (const auto* sphere = std::get_if<SphereLight>(&light.shape)) return sphere->center;
  if (const auto* point = std::get_if<PointLight>(&light.shape)) return point->position;
  if (const auto* spot = std::get_if<SpotLight>(&light.shape)) return spot->position;
  return fallback;
}

class SceneMaker {
 public:
  explicit SceneMaker(uint64_t seed) : dice_(seed), kind_(static_cast<int>(seed % kLightKinds)) {}

  std::shared_ptr<const Scene> Make() {
    receiver_ = RandomReceiver(dice_);
    light_ = RandomLight(dice_, kind_);
    AddOrdinary();
    AddThroughAndInTheReceiver();
    if (dice_.Below(4) == 0) AddAroundTheLight();
    AddDegenerate();
    delta_.upsert_lights = {light_};
    delta_.upsert_receivers = {receiver_};
    return Scene::Empty("random")->Apply(delta_).value();
  }

 private:
  Instance& Add(std::shared_ptr<const Mesh> mesh, const Affine& world_from_mesh) {
    delta_.upsert_instances.push_back({.id = absl::StrCat("i", delta_.upsert_instances.size()),
                                       .mesh = std::move(mesh),
                                       .world_from_mesh = world_from_mesh});
    return delta_.upsert_instances.back();
  }

  void AddOrdinary() {
    const auto box = MeshOf(UnitBoxGeometry());
    for (uint32_t i = 2 + dice_.Below(10); i > 0; --i) {
      Add(box, dice_.AnyAffine(dice_.Between(0.02f, 0.3f), dice_.InCube(2)));
    }
    Add(Triangles(dice_, 1 + dice_.Below(20), 0.4f), IdentityAffine());
    Add(Slivers(dice_, 1 + dice_.Below(20)), IdentityAffine());
    Add(Ball(5 + dice_.Below(8), 5 + dice_.Below(8)),
        dice_.AnyAffine(dice_.Between(0.1f, 0.4f), dice_.InCube(2)));
    Instance& sheet = Add(MeshOf(UnitSquareGeometry()), dice_.AnyAffine(0.7f, dice_.InCube(1.5f)));
    sheet.alpha_mask = Holes(dice_);
    sheet.alpha_cutoff = dice_.Between(0, 1);
  }

  void AddThroughAndInTheReceiver() {
    const Parallelogram& patch = std::get<Parallelogram>(receiver_.shape);
    Add(MeshOf(UnitBoxGeometry()),
        dice_.AnyAffine(0.2f, patch.At({dice_.Between(0, 1), dice_.Between(0, 1)})));
    const Vec3 normal = patch.normal();
    Add(MeshOf(UnitSquareGeometry()),
        Affine(0.5f * patch.edge_u, normal, -0.5f * patch.edge_v, patch.At({0.5f, 0.5f})));
  }

  void AddAroundTheLight() {
    const Vec3 at = SomewhereOn(light_, Vec3(0, 3, 0));
    Add(dice_.Below(2) == 0 ? MeshOf(UnitBoxGeometry()) : Triangles(dice_, 6, 0.3f),
        dice_.AnyAffine(dice_.Between(0.1f, 2), at));
  }

  void AddDegenerate() {
    Affine flat = dice_.AnyAffine(0.3f, dice_.InCube(2));
    flat[1] = Vec3(0.0f);
    Add(MeshOf(UnitBoxGeometry()), flat);
    Add(MeshOf(UnitBoxGeometry()), Affine(Vec3(0.0f), Vec3(0.0f), Vec3(0.0f), dice_.InCube(1)));
    Add(MeshOf({}), IdentityAffine());
    Add(MeshOf(UnitBoxGeometry()), Placed(Vec3(0.0f), 1.0f)).casts = false;
  }

  Dice dice_;
  const int kind_;
  Receiver receiver_;
  AreaLight light_;
  SceneDelta delta_;
};

}  // namespace

float Dice::Between(float lo, float hi) {
  return lo + (hi - lo) * static_cast<float>(UniformAt(seed_, index_++, 0));
}

uint32_t Dice::Below(uint32_t n) {
  return static_cast<uint32_t>(n * UniformAt(seed_, index_++, 0));
}

Vec3 Dice::InCube(float half) {
  const float x = Between(-half, half), y = Between(-half, half);
  return Vec3(x, y, Between(-half, half));
}

Vec3 Dice::Direction() {
  for (;;) {
    const Vec3 p = InCube(1);
    const float length = glm::length(p);
    if (length > 0.1f && length < 1) return p / length;
  }
}

Affine Dice::AnyAffine(float size, Vec3 position) {
  const Vec3 x = Direction(), y = Direction(), z = Direction();
  return Affine(size * x, size * Between(0.2f, 2) * y, size * z, position);
}

AreaLight RandomLight(Dice& dice, int kind) {
  const Vec3 at = dice.Between(1.5f, 5) * dice.Direction();
  const Vec3 strength = Vec3(dice.Between(0.5f, 2), dice.Between(0.5f, 2), dice.Between(0.5f, 2));
  switch (kind) {
    case 0:
      return {"light", RectangleLight{.corner = at,
                                      .edge_u = dice.Between(0.2f, 2) * dice.Direction(),
                                      .edge_v = dice.Between(0.2f, 2) * dice.Direction(),
                                      .radiance = strength}};
    case 1:
      return {"light", DiskLight{.center = at,
                                 .normal = dice.Direction(),
                                 .radius = dice.Between(0.1f, 1),
                                 .radiance = strength}};
    case 2:
      return {"light",
              SphereLight{.center = at, .radius = dice.Between(0.1f, 1), .radiance = strength}};
    case 3:
      return {"light", PointLight{.position = at, .intensity = strength}};
    case 4:
      return {"light", SpotLight{.position = at, .direction = -at, .intensity = strength}};
    default:
      return {"light", DistantLight{.to_light = at,
                                    .angular_diameter = dice.Below(4) == 0 ? 0 : dice.Between(0, 1),
                                    .irradiance = strength}};
  }
}

std::shared_ptr<const Scene> RandomScene(uint64_t seed) { return SceneMaker(seed).Make(); }

}  // namespace penumbra::testing
