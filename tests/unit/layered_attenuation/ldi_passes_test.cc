// How attenuation LDIs are built, pass by pass.
#include "render/technique/layered_attenuation/ldi_passes.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/layered_attenuation/ldi_sheets.h"

namespace penumbra {
namespace {

using testing::Lamp;
using testing::SceneOf;
using testing::Sheet;
using LdiPassesTest = testing::LdiPassesTest;

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
  // Some of its samples are below the near sheet and see nothing: portions have fewer views.
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
