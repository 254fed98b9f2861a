// Triangles and polygons as receivers: where their patch is, which texels lie on them, what is
// refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "render/scene/field_error.h"
#include "render/scene/receiver_place.h"
#include "render/scene/scene.h"
#include "render/scene/texture_size.h"
#include "tests/support/shapes.h"

namespace penumbra {
namespace {

Receiver PolygonReceiver(std::vector<Vec3> vertices, uint32_t width, uint32_t height) {
  return {.id = "r", .shape = PlanarPolygon{std::move(vertices)}, .width = width, .height = height};
}

std::shared_ptr<const CoverageMask> MaskOf(const ReceiverPatch& patch) {
  return CoverRegion(*patch.region, patch.width, patch.height);
}

// Which share of the patch lies inside, and the area that makes.
double InsideArea(const ReceiverPatch& patch) {
  const auto mask = MaskOf(patch);
  const double area = glm::length(glm::cross(DVec3(patch.patch.edge_u), DVec3(patch.patch.edge_v)));
  if (!mask) return area;
  return area * static_cast<double>(mask->CountInside()) / static_cast<double>(mask->texel_count());
}

TEST(ReceiverShapes, AnLHasAQuarterOutside) {
  const std::vector<Vec3> l = {{0, 5, 0}, {0, 5, 2}, {1, 5, 2}, {1, 5, 1}, {2, 5, 1}, {2, 5, 0}};
  const auto patch = PlaceReceiver(PolygonReceiver(l, 4, 4), nullptr);
  ASSERT_TRUE(patch.ok()) << patch.status();
  EXPECT_GT(patch->patch.normal().y, 0.99f) << "counter-clockwise seen from above";
  const auto mask = MaskOf(*patch);
  ASSERT_NE(mask, nullptr);
  EXPECT_EQ(mask->CountInside(), 12u);
  for (uint32_t j = 0; j < 4; ++j) {
    for (uint32_t i = 0; i < 4; ++i) {
      const Vec3 p = patch->TexelCenter(i, j);
      EXPECT_EQ(mask->At(i, j), !(p.x > 1 && p.z > 1)) << p.x << " " << p.z;
    }
  }
}

TEST(ReceiverShapes, ATurnedSquareFillsItsPatch) {
  const float c = std::cos(0.3f), s = std::sin(0.3f);
  std::vector<Vec3> square;
  for (const Vec2 p : {Vec2(0, 0), Vec2(3, 0), Vec2(3, 3), Vec2(0, 3)}) {
    square.emplace_back(c * p.x - s * p.y, s * p.x + c * p.y, 1);
  }
  const auto patch = PlaceReceiver(PolygonReceiver(square, 64, 64), nullptr);
  ASSERT_TRUE(patch.ok());
  EXPECT_EQ(MaskOf(*patch), nullptr) << "every texel is inside";
  EXPECT_NEAR(InsideArea(*patch), 9, 1e-4);
}

TEST(ReceiverShapes, AHexagonKeepsItsArea) {
  std::vector<Vec3> hexagon;
  for (int k = 0; k < 6; ++k) {
    const double angle = k * std::numbers::pi / 3;
    hexagon.emplace_back(std::cos(angle), std::sin(angle), 0);
  }
  const auto patch = PlaceReceiver(PolygonReceiver(hexagon, 256, 256), nullptr);
  ASSERT_TRUE(patch.ok());
  const double area = 1.5 * std::sqrt(3.0);
  // The smallest rectangle is 2 by √3; the outline passes some 3 · 256 texels.
  EXPECT_NEAR(glm::length(patch->patch.edge_u) * glm::length(patch->patch.edge_v),
              2 * std::sqrt(3.0), 1e-5);
  EXPECT_NEAR(InsideArea(*patch), area, 0.01 * area);
}

TEST(ReceiverShapes, ASliverHasAtLeastATexel) {
  const std::vector<Vec3> sliver = {{0, 0, 0}, {10, 0, 0}, {0, 0.01f, 0}};
  const auto fine = PlaceReceiver(PolygonReceiver(sliver, 64, 16), nullptr);
  ASSERT_TRUE(fine.ok()) << fine.status();
  EXPECT_NEAR(InsideArea(*fine), 0.05, 0.005);
  // A thorn whose tip alone reaches the row of centres.
  const PlanarRegion thorn{.points = {{0.4, 0.0}, {0.41, 0.0}, {0.405, 0.1}}, .ends = {3}};
  const auto mask = CoverRegion(thorn, 4, 1);
  ASSERT_NE(mask, nullptr);
  EXPECT_EQ(mask->CountInside(), 1u);
  EXPECT_TRUE(mask->At(1, 0));
  EXPECT_EQ(CoverRegion(thorn, 1, 1), nullptr);
}

TEST(ReceiverShapes, ATriangleIsHalfItsParallelogram) {
  const Receiver triangle{.id = "t",
                          .shape = Triangle{.corner = {1, 2, 3}, .edge_u = {4, 0, 0}},
                          .width = 8,
                          .height = 8};
  const auto patch = PlaceReceiver(triangle, nullptr);
  ASSERT_TRUE(patch.ok());
  EXPECT_EQ(patch->patch, (Parallelogram{{1, 2, 3}, {4, 0, 0}, {0, 0, -1}}));
  const auto mask = MaskOf(*patch);
  ASSERT_NE(mask, nullptr);
  for (uint32_t j = 0; j < 8; ++j) {
    for (uint32_t i = 0; i < 8; ++i) EXPECT_EQ(mask->At(i, j), i + j <= 7) << i << " " << j;
  }
}

// The turns that a walk around the polygon makes as seen from `p`: ±1 inside, 0 outside.
double WindingNumber(const std::vector<DVec2>& polygon, DVec2 p) {
  double angle = 0;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const DVec2 a = polygon[i] - p, b = polygon[(i + 1) % polygon.size()] - p;
    angle += std::atan2(a.x * b.y - a.y * b.x, glm::dot(a, b));
  }
  return angle / (2 * std::numbers::pi);
}

double DistanceToOutline(const std::vector<DVec2>& polygon, DVec2 p) {
  double nearest = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < polygon.size(); ++i) {
    const DVec2 a = polygon[i], along = polygon[(i + 1) % polygon.size()] - a;
    const double t = glm::clamp(glm::dot(p - a, along) / glm::dot(along, along), 0.0, 1.0);
    nearest = std::min(nearest, glm::length(p - a - t * along));
  }
  return nearest;
}

TEST(ReceiverShapes, TexelsOfRandomPolygonsAreInsideByTheirWindingNumber) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(0, 1);
  size_t inside = 0, outside = 0;
  for (int round = 0; round < 200; ++round) {
    const DVec3 s = glm::normalize(DVec3(uniform(random), uniform(random) - 2, uniform(random)));
    const DVec3 t = glm::normalize(glm::cross(s, DVec3(0, 1, uniform(random) + 0.5)));
    const DVec3 origin(10 * uniform(random), uniform(random), -3);
    const int corners = 3 + static_cast<int>(20 * uniform(random));
    std::vector<DVec2> flat;
    std::vector<Vec3> vertices;
    for (int k = 0; k < corners; ++k) {  // a star, so that no edges cross
      const double angle = 2 * std::numbers::pi * (k + 0.8 * uniform(random)) / corners;
      const double radius = 0.3 + 2 * uniform(random);
      vertices.emplace_back(origin + radius * (std::cos(angle) * s + std::sin(angle) * t));
      const DVec3 p(vertices.back());
      flat.emplace_back(glm::dot(p - origin, s), glm::dot(p - origin, t));
    }
    ASSERT_TRUE(CheckPolygon({vertices}, {}).ok()) << CheckPolygon({vertices}, {});
    const auto patch = PlaceReceiver(PolygonReceiver(vertices, 53, 37), nullptr);
    ASSERT_TRUE(patch.ok());
    const auto mask = MaskOf(*patch);
    const double texel = std::max(glm::length(patch->patch.edge_u) / 53.0f,
                                  glm::length(patch->patch.edge_v) / 37.0f);
    for (uint32_t j = 0; j < 37; ++j) {
      for (uint32_t i = 0; i < 53; ++i) {
        const DVec3 center(patch->TexelCenter(i, j));
        const DVec2 p(glm::dot(center - origin, s), glm::dot(center - origin, t));
        if (DistanceToOutline(flat, p) < 0.01 * texel) continue;
        const bool expected = std::abs(WindingNumber(flat, p)) > 0.5;
        ASSERT_EQ(mask == nullptr || mask->At(i, j), expected) << round << ": " << i << " " << j;
        ++(expected ? inside : outside);
      }
    }
  }
  EXPECT_GT(inside, 50'000u);
  EXPECT_GT(outside, 50'000u);
}

TEST(ReceiverShapes, SidesFollowTheSizeInTheWorld) {
  EXPECT_EQ(AutoSide(4.0, 64, 256), 256u);
  EXPECT_EQ(AutoSide(400.0, 64, 256), 256u);
  EXPECT_EQ(AutoSide(1.0, 64, 256), 64u);
  EXPECT_EQ(AutoSide(1.01, 64, 256), 128u);
  EXPECT_EQ(AutoSide(0.001, 64, 256), 16u);
  EXPECT_EQ(AutoSide(1000.0, 64, 300), 300u);
  EXPECT_EQ(AutoSide(1.0, 64, 5), 5u);
  const Receiver wall{
      .id = "w", .shape = Parallelogram{.edge_u = {2, 0, 0}, .edge_v = {0, 0.4f, 0}}, .height = 10};
  EXPECT_EQ(PlaceReceiver(wall, nullptr)->width, 128u);
  EXPECT_EQ(PlaceReceiver(wall, nullptr)->height, 10u) << "as asked for";
}

struct Refusal {
  const char* what;
  std::vector<Vec3> vertices;
  absl::StatusCode code;
  const char* reason;
  const char* field;
};

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;

const Refusal kRefusals[] = {
    {"two vertices", {{0, 0, 0}, {1, 0, 0}}, kInvalid, "LENGTH", "vertices"},
    {"NaN", {{0, 0, 0}, {1, 0, 0}, {0, kNaN, 0}}, kInvalid, "NON_FINITE", "vertices[2]"},
    {"far", {{0, 0, 0}, {2e9f, 0, 0}, {0, 1, 0}}, kInvalid, "OUT_OF_BOUNDS", "vertices[1]"},
    {"a line", {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, kInvalid, "ZERO_AREA", "vertices"},
    {"a point", {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}, kInvalid, "ZERO_AREA", "vertices"},
    {"bent", {{0, 0, 0}, {1, 0, 0}, {1, 1, 0.1f}, {0, 1, 0}}, kInvalid, "NOT_PLANAR", "vertices["},
    {"a bow",
     {{0, 0, 0}, {3, 0, 0}, {1, 2, 0}, {1, -1, 0}},
     kInvalid,
     "SELF_INTERSECTING",
     "vertices["},
    {"closed twice",
     {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 0, 0}},
     kInvalid,
     "SELF_INTERSECTING",
     "vertices["},
    {"a spike",
     {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {3, 3, 0}, {1, 1, 0}, {0, 1, 0}},
     kInvalid,
     "SELF_INTERSECTING",
     "vertices["},
    {"a corner on an edge",
     {{0, 0, 0}, {4, 0, 0}, {4, 2, 0}, {2, 0, 0}, {0, 2, 0}},
     kInvalid,
     "SELF_INTERSECTING",
     "vertices["},
    {"too many", std::vector<Vec3>(1025, Vec3(0)), absl::StatusCode::kResourceExhausted,
     "QUOTA_POLYGON_VERTICES", "vertices"},
};

TEST(ReceiverShapes, WrongPolygonsAreRefusedByField) {
  for (const Refusal& refusal : kRefusals) {
    SceneDelta delta;
    delta.upsert_receivers = {PolygonReceiver(refusal.vertices, 8, 8)};
    const auto scene = Scene::Empty("s")->Apply(delta);
    EXPECT_EQ(scene.status().code(), refusal.code) << refusal.what << ": " << scene.status();
    EXPECT_EQ(ErrorReason(scene.status()), refusal.reason) << refusal.what << scene.status();
    EXPECT_THAT(ErrorFieldPath(scene.status()),
                ::testing::StartsWith(std::string("upsert_receivers[0].") + refusal.field));
  }
}

TEST(ReceiverShapes, WrongTrianglesAndSizesAreRefusedByField) {
  const auto refused = [](const std::function<void(Receiver&)>& spoil) {
    SceneDelta delta;
    delta.upsert_receivers = {{.id = "r", .shape = Triangle{}}};
    EXPECT_TRUE(Scene::Empty("s")->Apply(delta).ok());
    spoil(delta.upsert_receivers[0]);
    return ErrorFieldPath(Scene::Empty("s")->Apply(delta).status());
  };
  EXPECT_EQ(refused([](Receiver& r) { r.shape = Triangle{.edge_v = Vec3(2, 0, 0)}; }),
            "upsert_receivers[0].edge_v");
  EXPECT_EQ(refused([](Receiver& r) { r.shape = Triangle{.corner = Vec3(kNaN)}; }),
            "upsert_receivers[0].corner");
  EXPECT_EQ(refused([](Receiver& r) { r.texels_per_metre = -1; }),
            "upsert_receivers[0].texels_per_metre");
  EXPECT_EQ(refused([](Receiver& r) { r.texels_per_metre = kNaN; }),
            "upsert_receivers[0].texels_per_metre");
  EXPECT_EQ(refused([](Receiver& r) { r.max_auto_side = 20'000; }),
            "upsert_receivers[0].max_auto_side");
  EXPECT_EQ(refused([](Receiver& r) { r.max_auto_side = 16'384; }), "upsert_receivers[0].width");
}

TEST(ReceiverShapes, AnInstanceMarksWhatItsTrianglesLeaveOut) {
  MeshGeometry frame{
      .positions =
          {{0, 0, 0}, {3, 0, 0}, {3, 3, 0}, {0, 3, 0}, {1, 1, 0}, {2, 1, 0}, {2, 2, 0}, {1, 2, 0}},
      .indices = {}};
  for (uint32_t k = 0; k < 4; ++k) {
    const uint32_t next = (k + 1) % 4;
    frame.indices.insert(frame.indices.end(), {k, next, 4 + next, k, 4 + next, 4 + k});
  }
  const Instance instance{.id = "frame", .mesh = testing::MeshOf(frame)};
  const Receiver receiver{.id = "r", .shape = PlanarInstance{"frame"}, .width = 30, .height = 30};
  const auto patch = PlaceReceiver(receiver, &instance);
  ASSERT_TRUE(patch.ok());
  const auto mask = MaskOf(*patch);
  ASSERT_NE(mask, nullptr);
  EXPECT_EQ(mask->CountInside(), 800u) << "all but the hole of 10 by 10, without cracks";
}

}  // namespace
}  // namespace penumbra
