// Limits, progress and errors of building attenuation LDIs.
#include "render/technique/layered_attenuation/ldi_passes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "proto/convert/ldi_codec.h"
#include "render/scene/field_error.h"
#include "tests/unit/layered_attenuation/ldi_of.h"

namespace penumbra {
namespace {

using ::testing::HasSubstr;
using testing::SceneOf;
using testing::Sheet;
using testing::UnitBoxGeometry;

AreaLight Lamp() {
  return {.id = "lamp", .shape = RectangleLight{.corner = {-0.5f, 4, -0.5f}, .two_sided = false}};
}

std::shared_ptr<const Scene> Sheets() {
  return SceneOf({Sheet({0, 0, 0}, 3, 3), Sheet({0.5f, 1, 0.2f}, 0.7f, 0.9f),
                  Sheet({-0.2f, 2, 0}, 0.3f, 0.5f)});
}

class LdiPassesTest : public ::testing::Test {
 protected:
  absl::StatusOr<std::unique_ptr<LdiPasses>> Create(const LdiOptions& options) {
    return LdiPasses::Create(*scene_, Lamp(), options, source_, arena_);
  }
  // Of all samples.
  absl::Status Build(const LdiOptions& options) {
    const auto passes = Create(options);
    return passes.ok() ? (*passes)->Advance(1024, {}) : passes.status();
  }

  const std::shared_ptr<const Scene> scene_ = Sheets();
  tbb::task_arena arena_{2};
  RasterDepthSource source_{*scene_, arena_};
};

struct BadOption {
  LdiOptions options;
  std::string field, found;
};

TEST_F(LdiPassesTest, AbsurdOptionsAreRefusedByName) {
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

TEST_F(LdiPassesTest, LimitsAreNamed) {
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
TEST_F(LdiPassesTest, TheLeastBytesAreThoseOfAllFaces) {
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
TEST_F(LdiPassesTest, ViewsThatWouldBeTooLargeAreRefused) {
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

TEST_F(LdiPassesTest, TheToleranceIsReported) {
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

TEST_F(LdiPassesTest, StopsWhenAsked) {
  std::stop_source stop;
  stop.request_stop();
  const auto passes = Create({.samples = 16, .resolution = 64});
  EXPECT_EQ((*passes)->Advance(16, stop.get_token()).code(), absl::StatusCode::kCancelled);
}

// A source that asks to stop after some views.
class StoppingSource : public DepthSource {
 public:
  StoppingSource(DepthSource& source, std::stop_source& stop) : source_(source), stop_(stop) {}

  absl::Status Draw(std::span<const LightView> views, const std::stop_token& stop,
                    const Take& take) override {
    return source_.Draw(views, stop, [&](size_t i, DepthMap map) {
      taken = i + 1;
      if (i == 20) stop_.request_stop();
      return take(i, std::move(map));
    });
  }

  std::string drawn_by() const override { return source_.drawn_by(); }

  size_t taken = 0;

 private:
  DepthSource& source_;
  std::stop_source& stop_;
};

// A source that notes the most pixels of a view.
class NotingSource : public DepthSource {
 public:
  explicit NotingSource(DepthSource& source) : source_(source) {}

  absl::Status Draw(std::span<const LightView> views, const std::stop_token& stop,
                    const Take& take) override {
    for (const LightView& view : views) most = std::max(most, view.width * view.height);
    drawn += views.size();
    return source_.Draw(views, stop, take);
  }

  std::string drawn_by() const override { return source_.drawn_by(); }

  uint32_t most = 0;
  size_t drawn = 0;

 private:
  DepthSource& source_;
};

// Of what casts nothing, only where it is: there may be thousands of such surfaces.
TEST_F(LdiPassesTest, SmallSurfacesAreDrawnIntoSmallViews) {
  const auto patch = SceneOf({Sheet({-1.5f, 0.5f, -1.5f}, 0.1f, 0.1f)});
  RasterDepthSource patch_source(*patch, arena_);
  NotingSource noted(patch_source);
  const auto passes = LdiPasses::Create(*scene_, Lamp(), {.samples = 4, .resolution = 128}, source_,
                                        arena_, {{patch, &noted}});
  ASSERT_TRUE((*passes)->Advance(4, {}).ok());
  EXPECT_EQ(noted.drawn, 5u);
  EXPECT_GT(noted.most, 0u);
  EXPECT_LT(noted.most, 15u * 15u);
  EXPECT_EQ(Visibility((*passes)->Finish(), {-1.5f, 0.5f, -1.5f}, {0, 1, 0}), 1.0f);
}

TEST_F(LdiPassesTest, StopsWithinASampleOrTwo) {
  std::stop_source stop;
  StoppingSource source(source_, stop);
  const auto passes =
      LdiPasses::Create(*scene_, Lamp(), {.samples = 1024, .resolution = 64}, source, arena_);
  EXPECT_EQ((*passes)->Advance(1024, stop.get_token()).code(), absl::StatusCode::kCancelled);
  EXPECT_LE(source.taken, 24u);
}

TEST_F(LdiPassesTest, EveryPassCountsMoreOfTheSameSamples) {
  const auto passes = Create({.samples = 256, .resolution = 128});
  const auto spot = [](int i) { return Vec3(-1.5f + 0.01f * static_cast<float>(i), 0, 0.3f); };
  std::vector<AttenuationLdi> ldis;
  for (const uint32_t upto : {8u, 64u, 256u}) {
    ASSERT_TRUE((*passes)->Advance(upto, {}).ok());
    EXPECT_EQ((*passes)->done(), upto);
    ldis.push_back((*passes)->Finish());
    EXPECT_EQ(ldis.back().sample_count, upto);
  }
  const auto off = [&](const AttenuationLdi& ldi) {
    testing::Deviation deviation;
    for (int i = 0; i < 300; ++i) {
      deviation.Add(Visibility(ldi, spot(i), {0, 1, 0}),
                    Visibility(ldis.back(), spot(i), {0, 1, 0}));
    }
    EXPECT_GT(deviation.partly_lit(), 50);
    return deviation.mean();
  };
  EXPECT_LT(off(ldis[0]), 0.06);
  EXPECT_LT(off(ldis[1]), 0.02);
  EXPECT_LT(off(ldis[1]), off(ldis[0]));
}

// How many samples a first pass counts depends on the clock; what comes of all must not.
TEST_F(LdiPassesTest, TheBitsDoNotDependOnWherePassesEnd) {
  // Some of its samples are below the near sheet and see nothing, so that portions have fewer views.
  const AreaLight globe{.id = "globe", .shape = SphereLight{.center = {0, 4, 0}, .radius = 1}};
  const auto beside =
      SceneOf({Sheet({0.72f, 3.25f, 0}, 0.02f, 0.1f), Sheet({0.7f, 3.2f, 0}, 0.05f, 0.1f),
               Sheet({0.74f, 3.22f, 0}, 0.04f, 0.02f)});
  for (const auto& [light, scene] : {std::pair{Lamp(), scene_}, std::pair{globe, beside}}) {
    RasterDepthSource source(*scene, arena_);
    const auto build = [&](const std::vector<uint32_t>& ends) {
      LdiOptions options{.samples = 100, .resolution = 64};
      options.limits.max_kept_bytes = 0;  // late layers are looked up in their own portion alone
      const auto passes = LdiPasses::Create(*scene, light, options, source, arena_).value();
      for (const uint32_t end : ends) {
        const absl::Status status = passes->Advance(end, {});
        EXPECT_TRUE(status.ok()) << status;
      }
      EXPECT_EQ(passes->done(), passes->sample_count());
      return passes->Finish();
    };
    const AttenuationLdi at_once = build({100});
    for (const auto& ends : {std::vector<uint32_t>{8, 64, 100}, {1, 9, 100}, {13, 98}}) {
      const AttenuationLdi ldi = build(ends);
      ASSERT_EQ(ldi.faces.size(), at_once.faces.size());
      for (size_t f = 0; f < ldi.faces.size(); ++f) {
        EXPECT_EQ(ldi.faces[f].offsets, at_once.faces[f].offsets) << ends[0];
        EXPECT_EQ(ldi.faces[f].depths, at_once.faces[f].depths) << ends[0];
        EXPECT_EQ(ldi.faces[f].counts, at_once.faces[f].counts) << ends[0];
      }
    }
  }
}

// Layers found by the last samples are looked up in the first ones' maps.
TEST_F(LdiPassesTest, LateLayersAreCountedAsIfTheyHadBeenKnown) {
  const auto all_at_once = Create({.samples = 64, .resolution = 128});
  ASSERT_TRUE((*all_at_once)->Advance(64, {}).ok());
  LdiOptions forgetful{.samples = 64, .resolution = 128};
  forgetful.limits.max_kept_bytes = 0;
  const auto forgets = Create(forgetful);
  ASSERT_TRUE((*forgets)->Advance(64, {}).ok());
  const LdiFace kept = (*all_at_once)->Finish().faces[0], lost = (*forgets)->Finish().faces[0];
  ASSERT_EQ(kept.depths, lost.depths);
  int64_t more = 0;
  for (size_t k = 0; k < kept.counts.size(); ++k) {
    EXPECT_GE(kept.counts[k], lost.counts[k]);
    more += kept.counts[k] - lost.counts[k];
  }
  EXPECT_GT(more, 0);
}

TEST_F(LdiPassesTest, KeyViewsComeCloseToDrawing) {
  for (const uint32_t samples : {64u, 256u}) {
    LdiOptions options{.samples = samples, .resolution = 256};
    const AttenuationLdi drawn = testing::LdiOf(*scene_, Lamp(), options);
    options.key_views = true;
    const AttenuationLdi warped = testing::LdiOf(*scene_, Lamp(), options);
    testing::Deviation off;
    for (float x = -2; x <= 2; x += 0.02f) {
      for (float z = -2; z <= 2; z += 0.1f) {
        off.Add(Visibility(warped, Vec3(x, 0, z), {0, 1, 0}),
                Visibility(drawn, Vec3(x, 0, z), {0, 1, 0}));
      }
    }
    EXPECT_GT(off.partly_lit(), 500);
    EXPECT_LT(off.mean(), 0.01);
    EXPECT_LT(std::abs(off.bias()), 0.008);
  }
}

}  // namespace
}  // namespace penumbra
