#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "absl/strings/str_cat.h"
#include "tests/unit/import/temp_folder.h"

namespace penumbra {
namespace {

using absl::StatusCode;
using testing::HasSubstr;

constexpr char kSquare[] = "v 0 0 0\nv 0 0 1\nv 1 0 1\nv 1 0 0\n";

absl::StatusOr<ImportedScene> WithMaterials(const std::string& obj, const std::string& mtl) {
  const TempFolder folder;
  folder.Write("m.mtl", mtl);
  return ImportScene(folder.Write("model.obj", absl::StrCat("mtllib m.mtl\n", obj)));
}

TEST(Obj, ObjectsAndMaterialsBecomeInstances) {
  const auto scene = WithMaterials(std::string(kSquare) +
                                       "o top\nusemtl red\nf 1 2 3\nusemtl blue\nf 1 3 4\n"
                                       "o other side\nusemtl red\nf -4 -3 -2 -1\n",
                                   "newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 0.5\n");
  ASSERT_TRUE(scene.ok()) << scene.status();
  ASSERT_EQ(scene->instances.size(), 3u);
  EXPECT_EQ(InstanceOf(*scene, "top.red").color, Vec3(1, 0, 0));
  EXPECT_EQ(InstanceOf(*scene, "top.blue").color, Vec3(0, 0, 0.5f));
  EXPECT_EQ(InstanceOf(*scene, "top.blue").mesh->vertex_count(), 3u);
  EXPECT_EQ(InstanceOf(*scene, "other_side").mesh->triangle_count(), 2u);
}

TEST(Obj, GlowingQuadsAreLights) {
  for (const char* glow : {"Ke 20 10 5\n", "Ka 20 10 5\n"}) {
    const auto scene = WithMaterials(std::string(kSquare) + "o lamp\nusemtl glow\nf 4 3 2 1\n",
                                     absl::StrCat("newmtl glow\nKd 1 1 1\n", glow));
    ASSERT_TRUE(scene.ok()) << scene.status();
    const auto light = std::get<RectangleLight>(LightOf(*scene, "lamp").shape);
    EXPECT_EQ(light.radiance, Vec3(20, 10, 5));
    EXPECT_LT(glm::cross(light.edge_u, light.edge_v).y, -0.99f);
    EXPECT_FALSE(InstanceOf(*scene, "lamp").casts);
    EXPECT_FALSE(InstanceOf(*scene, "lamp").receives);
  }
}

TEST(Obj, WhatGlowsButIsNoLightCastsAndReceives) {
  const auto scene = WithMaterials(std::string(kSquare) + "o corner\nusemtl glow\nf 1 2 3\n",
                                   "newmtl glow\nKe 1 1 1\n");
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_TRUE(scene->lights.empty());
  EXPECT_TRUE(InstanceOf(*scene, "corner").casts);
  EXPECT_TRUE(InstanceOf(*scene, "corner").receives);
}

TEST(Obj, AnAmbientReflectanceDoesNotGlow) {
  const auto scene = WithMaterials(std::string(kSquare) + "usemtl m\nf 1 2 3 4\n",
                                   "newmtl m\nKa 1 1 1\nKd 0.5 0.5 0.5\n");
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_TRUE(scene->lights.empty());
}

TEST(Obj, ThinMaterialsCastNoShadow) {
  const auto scene =
      WithMaterials(std::string(kSquare) + "o pane\nusemtl m\nf 1 2 3 4\n", "newmtl m\nd 0.2\n");
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_FALSE(InstanceOf(*scene, "pane").casts);
}

TEST(Obj, E17LibrariesOutsideTheFolderAreNotOpened) {
  const TempFolder folder;
  folder.Write("up.mtl", "newmtl red\nKd 1 0 0\n");
  const auto scene = ImportScene(folder.Write(
      "sub/a.obj", std::string(kSquare) + "mtllib ../up.mtl\nusemtl red\no a\nf 1 2 3\n"));
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_EQ(InstanceOf(*scene, "a").color, Vec3(0.8f));
  EXPECT_THAT(scene->warnings, testing::Contains(HasSubstr("mtllib: found \"../up.mtl\"")));
}

TEST(Obj, FacesOfAbsurdlyManyCornersAreRefused) {
  std::string face = "f";
  for (int i = 0; i < 100'000; ++i) absl::StrAppend(&face, " ", 1 + i % 4);
  const auto scene = ImportBytes("a.obj", kSquare + face + "\n");
  EXPECT_EQ(scene.status().code(), StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(scene.status().message()), HasSubstr("line 5"));
}

TEST(Obj, AnEmptyFileIsAnEmptySceneWithAWarning) {
  const auto scene = ImportBytes("a.obj", "# nothing\n");
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_TRUE(scene->instances.empty());
  EXPECT_THAT(scene->warnings, testing::Contains(HasSubstr("no faces")));
}

}  // namespace
}  // namespace penumbra
