// Options, limits and errors of building attenuation LDIs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "proto/convert/ldi_codec.h"
#include "render/scene/field_error.h"
#include "tests/unit/layered_attenuation/ldi_sheets.h"

namespace penumbra {
namespace {

using ::testing::HasSubstr;
using testing::Lamp;
using testing::SceneOf;
using testing::Sheet;
using testing::UnitBoxGeometry;

class LdiLimitsTest : public testing::LdiPassesTest {};

struct BadOption {
  LdiOptions options;
  std::string field, found;
};

TEST_F(LdiLimitsTest, AbsurdOptionsAreRefusedByName) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  for (const auto& [options, field, found] :
       {BadOption{{.samples = 0}, "samples", "found 0, need 1 to 1024"},
        BadOption{{.samples = 1025}, "samples", "found 1025"},
        BadOption{{.resolution = 7}, "resolution", "found 7, need 8 to 8192"},
        BadOption{{.resolution = 8193}, "resolution", "found 8193"},
        BadOption{{.tolerance = 0.0f}, "tolerance", "found 0, need more than 0 and at most 16"},
        BadOption{{.tolerance = -1.0f}, "tolerance", "found -1"},
        BadOption{{.tolerance = 16.5f}, "tolerance", "found 16.5"},
        BadOption{{.tolerance = nan}, "tolerance", "found nan"},
        BadOption{{.tolerance = infinity}, "tolerance", "found inf"}}) {
    const absl::Status status = Create(options).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << status;
    EXPECT_EQ(ErrorFieldPath(status), field);
    EXPECT_NE(std::string(status.message()).find(found), std::string::npos) << status;
  }
}

TEST_F(LdiLimitsTest, LimitsAreNamed) {
  LdiOptions options{.samples = 64, .resolution = 128};
  options.limits.max_layers = 1;
  absl::Status status = Build(options);
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted) << status;
  EXPECT_EQ(ErrorFieldPath(status), "max_layers");
  EXPECT_THAT(status.message(), HasSubstr("found 2 layers at a pixel, need at most 1"));

  // Before anything is drawn, and where what is drawn turns out to be more than the least.
  options.limits = {.max_bytes = 128 * 128 * 60};
  const absl::Status at_once = Create(options).status();
  options.limits = {.max_bytes = 128 * 128 * 120};
  ASSERT_TRUE(Create(options).ok());
  for (const absl::Status& refused : {at_once, Build(options)}) {
    EXPECT_EQ(refused.code(), absl::StatusCode::kResourceExhausted) << refused;
    EXPECT_EQ(ErrorReason(refused), "QUOTA_LDI_BYTES");
    EXPECT_EQ(ErrorFieldPath(refused), "resolution");
    EXPECT_THAT(refused.message(), HasSubstr("found one at which layers and maps take "));
    EXPECT_THAT(refused.message(), HasSubstr("bytes, need at most "));
  }
  options.limits.max_kept_bytes = 0;
  EXPECT_TRUE(Build(options).ok()) << "maps are not what it lacks room for";
}

// All faces count, and key views take more.
TEST_F(LdiLimitsTest, TheLeastBytesAreThoseOfAllFaces) {
  const AreaLight bulb{.id = "bulb", .shape = PointLight{.position = {0, 0.5f, 0}}};
  const auto box = SceneOf({testing::Placed(UnitBoxGeometry())});
  const auto status = [&](const AreaLight& light, const LdiOptions& options) {
    return LdiPasses::Create(*box, light, options, source_, arena_).status();
  };
  LdiOptions options{.samples = 64, .resolution = 128};
  options.limits.max_bytes = 128 * 128 * (30 * 6 + 5);  // of six faces and one map
  EXPECT_TRUE(status(bulb, options).ok());
  options.limits.max_bytes -= 10'000;
  EXPECT_EQ(ErrorFieldPath(status(bulb, options)), "resolution");

  options.limits.max_bytes = 128 * 128 * 100;
  EXPECT_TRUE(Create(options).ok());
  options.key_views = true;
  EXPECT_EQ(ErrorFieldPath(Create(options).status()), "resolution");
}

// Whose pixels would have to be larger than those that its map is looked up by.
TEST_F(LdiLimitsTest, ViewsThatWouldBeTooLargeAreRefused) {
  const auto floor = SceneOf({Sheet({0, 2.5f, 0}, 3, 0.002f)});
  const AreaLight lamp{.id = "lamp",
                       .shape = RectangleLight{.corner = {-3, 4, -0.001f},
                                               .edge_u = {6, 0, 0},
                                               .edge_v = {0, 0, 0.002f},
                                               .two_sided = false}};
  RasterDepthSource source(*floor, arena_);
  const auto build = [&](uint32_t resolution) {
    return LdiPasses::Create(*floor, lamp, {.samples = 4, .resolution = resolution}, source, arena_)
        .status();
  };
  EXPECT_TRUE(build(1024).ok()) << build(1024);
  const absl::Status status = build(8192);
  EXPECT_EQ(ErrorReason(status), "VIEW_SIZE");
  EXPECT_EQ(ErrorFieldPath(status), "resolution");
  EXPECT_THAT(status.message(), HasSubstr("need at most 16384"));
}

TEST_F(LdiLimitsTest, TheToleranceIsReported) {
  const auto automatic = Create({.samples = 4, .resolution = 64});
  ASSERT_TRUE((*automatic)->Advance(4, {}).ok());
  EXPECT_EQ((*automatic)->Finish().tolerance, kAutomaticLdiTolerance);
  const auto given = Create({.samples = 4, .resolution = 64, .tolerance = 2.5f});
  ASSERT_TRUE((*given)->Advance(4, {}).ok());
  EXPECT_EQ((*given)->Finish().tolerance, 2.5f);
}

// Each pixel's depths are different ones, as tiles must have them, however little is asked for.
TEST(LdiToleranceTest, LayersThatOnlyRoundingTellsApartAreOne) {
  const AreaLight globe{.id = "globe", .shape = SphereLight{.center = {0, 5, 0}, .radius = 0.5f}};
  const auto scene = SceneOf({testing::Placed(testing::BallGeometry(12, 8))});
  for (const float tolerance : {1e-30f, 1e-5f}) {
    const AttenuationLdi ldi =
        testing::LdiOf(*scene, globe, {.samples = 32, .resolution = 64, .tolerance = tolerance});
    EXPECT_GT(ldi.tolerance, tolerance);
    EXPECT_LT(ldi.tolerance, 0.01f);
    LdiTileEncoder encoder;
    LdiTiles tiles(ldi);
    for (const LdiTilePlace& place : LdiTilesOf(ldi)) {
      const absl::Status added = tiles.Add(encoder.Encode(ldi, place));
      ASSERT_TRUE(added.ok()) << added;
    }
  }
}

}  // namespace
}  // namespace penumbra
