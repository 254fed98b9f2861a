#include "client/display/deep_exr.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <string>

#include "client/display/light_text.h"
#include "tests/support/random_ldi.h"
#include "tests/support/temporary_folder.h"

namespace penumbra {
namespace {

std::filesystem::path TemporaryPath(const std::string& name) {
  return std::filesystem::path(::testing::TempDir()) / ("penumbra_" + name);
}

TEST(DeepExrTest, IsReadBackIdentical) {
  for (const uint32_t samples : {1u, 64u, 1000u}) {
    const AttenuationLdi ldi = RandomLdi(samples);
    const auto path = TemporaryPath("layers.exr");
    const absl::Status written = WriteDeepExr(path, ldi);
    ASSERT_TRUE(written.ok()) << written;
    const auto back = ReadDeepExr(path);
    ASSERT_TRUE(back.ok()) << back.status();
    EXPECT_EQ(back->light, ldi.light);
    EXPECT_EQ(back->sample_count, ldi.sample_count);
    EXPECT_EQ(back->tolerance, ldi.tolerance);
    ASSERT_EQ(back->faces.size(), ldi.faces.size());
    for (size_t f = 0; f < ldi.faces.size(); ++f) {
      const LdiFace &found = back->faces[f], &expected = ldi.faces[f];
      EXPECT_EQ(found.offsets, expected.offsets);
      EXPECT_EQ(found.depths, expected.depths);
      EXPECT_EQ(found.counts, expected.counts);
      EXPECT_EQ(found.view.width, expected.view.width);
      EXPECT_EQ(found.view.height, expected.view.height);
      EXPECT_EQ(found.view.from_infinity, expected.view.from_infinity);
      EXPECT_EQ(found.view.frame.origin, expected.view.frame.origin);
      EXPECT_EQ(found.view.frame.axes.t, expected.view.frame.axes.t);
      EXPECT_EQ(found.view.window.min, expected.view.window.min);
      EXPECT_EQ(found.view.window.max, expected.view.window.max);
      EXPECT_EQ(found.view.near, expected.view.near);
      EXPECT_EQ(found.view.far, expected.view.far);
    }
    std::filesystem::remove(path);
  }
}

// oiiotool's word for it: another program sees two deep parts with these channels and attributes.
TEST(DeepExrTest, OtherProgramsReadIt) {
  if (std::system("oiiotool --help > /dev/null 2>&1") != 0) {
    GTEST_SKIP() << "oiiotool is not installed";
  }
  const auto path = TemporaryPath("for_others.exr"), text = TemporaryPath("for_others.txt");
  ASSERT_TRUE(WriteDeepExr(path, RandomLdi(64)).ok());
  const std::string command = "oiiotool --info -v -a " + path.string() + " > " + text.string();
  ASSERT_EQ(std::system(command.c_str()), 0);
  std::ifstream file(text);
  const std::string told((std::istreambuf_iterator<char>(file)), {});
  for (const char* what :
       {"70 x   33, 2 channel, deep float openexr", "channel list: Z, attenuation", "worldToCamera",
        "worldToNDC", "penumbra:sample_count: 64", "penumbra:light: \"lamp disk", "2 subimages"}) {
    EXPECT_THAT(told, ::testing::HasSubstr(what));
  }
  std::filesystem::remove(path);
  std::filesystem::remove(text);
}

TEST(DeepExrTest, WhatIsNoneIsTold) {
  EXPECT_TRUE(absl::IsNotFound(ReadDeepExr(TemporaryPath("nowhere.exr")).status()));
  const auto path = TemporaryPath("text.exr");
  std::ofstream(path) << "no picture";
  EXPECT_TRUE(absl::IsInvalidArgument(ReadDeepExr(path).status()));
  std::filesystem::remove(path);
  EXPECT_TRUE(absl::IsInvalidArgument(WriteDeepExr(path, AttenuationLdi{})));
  EXPECT_TRUE(absl::IsUnavailable(WriteDeepExr(TemporaryPath("no/such/folder.exr"), RandomLdi(4))));
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(LightTextTest, EveryLightGoesThereAndBack) {
  const LightShape shapes[] = {
      RectangleLight{.corner = {0.1f, 2, 3}, .two_sided = false},
      DiskLight{.center = {1, 1e-7f, 3}, .radius = 0.3f},
      SphereLight{.radius = 1.0f / 3},
      PointLight{.intensity = {1, 2, 3e20f}},
      SpotLight{.inner_angle = 0.1f},
      DistantLight{.angular_diameter = 0.00925f},
  };
  for (const LightShape& shape : shapes) {
    const AreaLight light{.id = "lamp-1", .shape = shape};
    const auto back = LightFromText(LightText(light));
    ASSERT_TRUE(back.ok()) << LightText(light);
    EXPECT_EQ(*back, light);
  }
}

TEST(LightTextTest, WhatIsNoLightIsRefused) {
  for (const char* text : {"", "lamp", "lamp torch 1 2 3", "lamp sphere 1 2 3 4 5 6",
                           "lamp sphere 1 2 3 4 5 6 7 8", "lamp sphere 1 2 3 x 5 6 7"}) {
    EXPECT_FALSE(LightFromText(text).ok()) << text;
  }
}

TEST(DeepExrTest, ALinkGoesOnLeadingToTheFileAndAPipeStays) {
  const testing::TemporaryFolder folder;
  std::ofstream(folder / "layers.exr") << "before";
  std::filesystem::create_symlink("layers.exr", folder / "link.exr");
  ASSERT_EQ(WriteDeepExr(folder / "link.exr", RandomLdi(4)), absl::OkStatus());
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link.exr"));
  EXPECT_EQ(ReadDeepExr(folder / "layers.exr").status(), absl::OkStatus());

  const std::string pipe = folder / "pipe.exr";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_TRUE(absl::IsUnavailable(WriteDeepExr(pipe, RandomLdi(4))));
  EXPECT_TRUE(std::filesystem::is_fifo(pipe));
}

}  // namespace
}  // namespace penumbra
