#include "client/cli/light_option.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <string>

namespace penumbra {
namespace {

using ::testing::HasSubstr;

const LightOption& OptionOf(const std::string& name) {
  for (const LightOption& option : LightOptions()) {
    if (option.name == name) return option;
  }
  ADD_FAILURE() << "no option " << name;
  return LightOptions().front();
}

template <typename Shape>
Shape Parsed(const std::string& name, const std::string& text) {
  const auto shape = ParseLight(OptionOf(name), text);
  EXPECT_TRUE(shape.ok()) << shape.status();
  return shape.ok() ? std::get<Shape>(*shape) : Shape{};
}

TEST(LightOptionTest, Rectangle) {
  const auto light = Parsed<RectangleLight>("--rect-light", "1 2 3, 4 5 6, 7 8 9, 10 11 12");
  EXPECT_EQ(light.corner, Vec3(1, 2, 3));
  EXPECT_EQ(light.edge_u, Vec3(4, 5, 6));
  EXPECT_EQ(light.edge_v, Vec3(7, 8, 9));
  EXPECT_EQ(light.radiance, Vec3(10, 11, 12));
  EXPECT_TRUE(light.two_sided);
  EXPECT_EQ(Parsed<RectangleLight>("--rect-light", "1,2,3,4,5,6,7,8,9,10").radiance, Vec3(10));
}

TEST(LightOptionTest, DiskAndSphere) {
  const auto disk = Parsed<DiskLight>("--disk-light", "1 2 3  0 -1 0  0.5  4 5 6");
  EXPECT_EQ(disk.center, Vec3(1, 2, 3));
  EXPECT_EQ(disk.normal, Vec3(0, -1, 0));
  EXPECT_EQ(disk.radius, 0.5f);
  EXPECT_EQ(disk.radiance, Vec3(4, 5, 6));
  const auto sphere = Parsed<SphereLight>("--sphere-light", "1 2 3  0.25  7");
  EXPECT_EQ(sphere.center, Vec3(1, 2, 3));
  EXPECT_EQ(sphere.radius, 0.25f);
  EXPECT_EQ(sphere.radiance, Vec3(7));
}

TEST(LightOptionTest, PointAndSpot) {
  const auto point = Parsed<PointLight>("--point-light", "1 2 3  4");
  EXPECT_EQ(point.position, Vec3(1, 2, 3));
  EXPECT_EQ(point.intensity, Vec3(4));
  const auto spot = Parsed<SpotLight>("--spot-light", "1 2 3  0 -1 0  5  30 45");
  EXPECT_EQ(spot.direction, Vec3(0, -1, 0));
  EXPECT_EQ(spot.intensity, Vec3(5));
  EXPECT_FLOAT_EQ(spot.inner_angle, std::numbers::pi_v<float> / 6);
  EXPECT_FLOAT_EQ(spot.outer_angle, std::numbers::pi_v<float> / 4);
  EXPECT_EQ(Parsed<SpotLight>("--spot-light", "1 2 3  0 -1 0  5 6 7  30 45").intensity,
            Vec3(5, 6, 7));
}

TEST(LightOptionTest, SunWithAndWithoutADiameter) {
  const auto hard = Parsed<DistantLight>("--sun", "1 2 3  4");
  EXPECT_EQ(hard.to_light, Vec3(1, 2, 3));
  EXPECT_EQ(hard.irradiance, Vec3(4));
  EXPECT_EQ(hard.angular_diameter, 0.0f);
  const auto soft = Parsed<DistantLight>("--sun", "1 2 3  4  0.53");
  EXPECT_EQ(soft.irradiance, Vec3(4));
  EXPECT_NEAR(soft.angular_diameter, 0.00925f, 1e-5f);
  EXPECT_EQ(Parsed<DistantLight>("--sun", "1 2 3  4 5 6").irradiance, Vec3(4, 5, 6));
  const auto coloured = Parsed<DistantLight>("--sun", "1 2 3  4 5 6  180");
  EXPECT_EQ(coloured.irradiance, Vec3(4, 5, 6));
  EXPECT_FLOAT_EQ(coloured.angular_diameter, std::numbers::pi_v<float>);
}

TEST(LightOptionTest, WrongAnglesAreToldInDegrees) {
  const auto error = [](const std::string& name, const std::string& text) {
    const LightOption& option = OptionOf(name);
    return std::string(CheckAngles(option, ParseLight(option, text).value()).message());
  };
  EXPECT_EQ(error("--spot-light", "0 3 0  0 -1 0  10  50 30"),
            "--spot-light.inner_deg: found 50, need 0 to less than 30");
  EXPECT_EQ(error("--spot-light", "0 3 0  0 -1 0  10  30 30"),
            "--spot-light.inner_deg: found 30, need 0 to less than 30");
  EXPECT_EQ(error("--spot-light", "0 3 0  0 -1 0  10  30 91"),
            "--spot-light.outer_deg: found 91, need 0.006 to 90");
  EXPECT_EQ(error("--spot-light", "0 3 0  0 -1 0  10  0 90"), "");
  EXPECT_EQ(error("--sun", "0 1 0  3  180"), "--sun.angular_diameter_deg: found 180, need 0 to 90");
  EXPECT_EQ(error("--sun", "0 1 0  3"), "");
  EXPECT_EQ(error("--point-light", "0 1 0  3"), "");
}

TEST(LightOptionTest, AWrongCountNamesTheForm) {
  for (const LightOption& option : LightOptions()) {
    const auto shape = ParseLight(option, "1 2");
    ASSERT_FALSE(shape.ok()) << option.name;
    EXPECT_THAT(std::string(shape.status().message()),
                ::testing::AllOf(HasSubstr(option.name), HasSubstr("found 2 numbers"),
                                 HasSubstr(option.form)));
    EXPECT_FALSE(ParseLight(option, std::string(40, '1').append(" 2").c_str()).ok());
  }
  EXPECT_FALSE(ParseLight(OptionOf("--rect-light"), "1 2 3 4 5 6 7 8 9 10 11").ok());
  EXPECT_FALSE(ParseLight(OptionOf("--sun"), "1 2 3 4 5 6 7 8").ok());
}

}  // namespace
}  // namespace penumbra
