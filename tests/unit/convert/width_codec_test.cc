#include "proto/convert/width_codec.h"

#include <gtest/gtest.h>

#include <string>

#include "proto/convert/artifact_assembler.h"
#include "proto/convert/artifact_convert.h"
#include "proto/convert/width_convert.h"
#include "render/scene/field_error.h"
#include "tests/support/random_width_map.h"

namespace penumbra {
namespace {

Artifact ArtifactOf(ShadowWidthMap map) {
  Artifact artifact{.header = {}, .payload = std::move(map)};
  artifact.header.light_samples = {{}};
  return artifact;
}

// The update that brings all of the artifact, but for the tiles that are in `without`.
v1::ArtifactUpdate UpdateOf(const Artifact& artifact, uint64_t base,
                            const ShadowWidthMap* without = nullptr) {
  const auto& map = std::get<ShadowWidthMap>(artifact.payload);
  v1::ArtifactUpdate update;
  update.set_base_sequence(base);
  update.set_update_sequence(base + 1);
  *update.mutable_header() = ToProto(artifact);
  update.set_light_samples(EncodeLightSamples(artifact.header.light_samples));
  WidthTileEncoder encoder;
  for (const WidthTilePlace& place : WidthTilesOf(map)) {
    if (without && WidthTilesEqual(*without, map, place)) continue;
    *update.add_width_tiles() = encoder.Encode(map, place);
  }
  update.set_end_of_update(true);
  return update;
}

void ExpectSame(const ShadowWidthMap& found, const ShadowWidthMap& expected) {
  EXPECT_EQ(found.light, expected.light);
  EXPECT_EQ(found.c_scale, expected.c_scale);
  EXPECT_EQ(found.c_bias, expected.c_bias);
  ASSERT_TRUE(HaveSameFaces(found, expected));
  for (size_t f = 0; f < found.faces.size(); ++f) {
    EXPECT_EQ(found.faces[f].near.depths, expected.faces[f].near.depths);
    EXPECT_EQ(found.faces[f].near.widths, expected.faces[f].near.widths);
    if (!expected.faces[f].far) continue;
    EXPECT_EQ(found.faces[f].far->depths, expected.faces[f].far->depths);
    EXPECT_EQ(found.faces[f].far->widths, expected.faces[f].far->widths);
  }
}

const ShadowWidthMap& MapOf(const std::optional<ArtifactUpdate>& update) {
  return std::get<ShadowWidthMap>(update->artifact->payload);
}

TEST(WidthCodecTest, MapsGoThereAndBack) {
  for (const bool has_far : {false, true}) {
    ShadowWidthMap map = RandomWidthMap(1, has_far);
    if (has_far) map.c_scale = 2.5f, map.c_bias = 0.125f;
    map.faces[0].near.widths[3] = kNoDepth;  // nothing is lit
    ArtifactAssembler assembler;
    const auto update = assembler.Add(UpdateOf(ArtifactOf(map), 0));
    ASSERT_TRUE(update.ok()) << update.status();
    ExpectSame(MapOf(*update), map);
  }
}

TEST(WidthCodecTest, TilesLeftOutAreAsTheyWere) {
  for (const bool has_far : {false, true}) {
    const ShadowWidthMap before = RandomWidthMap(2, has_far);
    ShadowWidthMap after = before;
    // In the second row of tiles, with the constants.
    after.faces[0].near.widths[size_t{70} * 80 + 3] += 0.5f;
    after.c_bias = 0.25f;
    ArtifactAssembler assembler;
    ASSERT_TRUE(assembler.Add(UpdateOf(ArtifactOf(before), 0)).ok());
    const v1::ArtifactUpdate difference = UpdateOf(ArtifactOf(after), 1, &before);
    EXPECT_EQ(difference.width_tiles_size(), 1);
    const auto update = assembler.Add(difference);
    ASSERT_TRUE(update.ok()) << update.status();
    ExpectSame(MapOf(*update), after);
  }
}

TEST(WidthCodecTest, OtherFacesNeedAllTiles) {
  const ShadowWidthMap before = RandomWidthMap(3, false);
  ShadowWidthMap after = before;
  after.faces[0].window.max.x = 1.25;
  ArtifactAssembler assembler;
  ASSERT_TRUE(assembler.Add(UpdateOf(ArtifactOf(before), 0)).ok());
  const auto update = assembler.Add(UpdateOf(ArtifactOf(after), 1, &before));
  EXPECT_EQ(update.status().code(), absl::StatusCode::kDataLoss);
  EXPECT_EQ(ErrorReason(update.status()), "INCOMPLETE");
}

v1::WidthTile FirstTile(const ShadowWidthMap& map) {
  return WidthTileEncoder().Encode(map, {0, 0, 0});
}

void ExpectRefused(const v1::WidthTile& tile, const char* reason, const char* field) {
  ShadowWidthMap map = RandomWidthMap(4, false);
  WidthTiles tiles(map, nullptr);
  const auto status = tiles.Add(tile, map);
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(ErrorReason(status), reason);
  EXPECT_EQ(ErrorFieldPath(status), field);
}

TEST(WidthCodecTest, TilesThatAreNoneAreRefused) {
  const ShadowWidthMap map = RandomWidthMap(4, false);
  v1::WidthTile tile = FirstTile(map);
  tile.set_face(2);
  ExpectRefused(tile, "RANGE", "width_tile");
  tile = FirstTile(map);
  tile.set_row(3);
  ExpectRefused(tile, "RANGE", "width_tile");
  tile = FirstTile(map);
  tile.mutable_planes()->RemoveLast();
  ExpectRefused(tile, "RANGE", "width_tile.planes");
  tile = FirstTile(map);
  tile.mutable_planes(1)->set_codec(v1::CODEC_ALL_VISIBLE);
  ExpectRefused(tile, "CODEC", "width_tile.planes[1]");
  tile = FirstTile(map);
  tile.mutable_planes(0)->set_codec(v1::CODEC_RAW);
  tile.mutable_planes(0)->set_packed("short");
  ExpectRefused(tile, "LENGTH", "width_tile.planes[0]");
}

TEST(WidthCodecTest, NumbersThatAreNoneAreRefused) {
  for (const float bad : {-0.1f, std::nanf("")}) {
    ShadowWidthMap map = RandomWidthMap(5, false);
    map.faces[0].near.widths[1] = bad;
    ExpectRefused(FirstTile(map), "RANGE", "width_tile.planes[1]");
    map = RandomWidthMap(5, false);
    map.faces[0].near.depths[1] = bad;
    ExpectRefused(FirstTile(map), "RANGE", "width_tile.planes[0]");
  }
}

TEST(WidthCodecTest, HeadersThatCannotBeAreRefused) {
  const auto refused = [](const v1::ShadowWidthMap& proto, const char* field) {
    const auto map = FromProto(proto, SceneLimits{});
    EXPECT_EQ(map.status().code(), absl::StatusCode::kInvalidArgument) << field;
    EXPECT_EQ(ErrorFieldPath(map.status()), field);
  };
  const v1::ShadowWidthMap good = ToProto(RandomWidthMap(6, true));
  ASSERT_TRUE(FromProto(good, SceneLimits{}).ok());
  v1::ShadowWidthMap bad = good;
  bad.set_c_scale(-1);
  refused(bad, "shadow_width_map.c_scale");
  bad = good;
  bad.set_c_bias(std::nanf(""));
  refused(bad, "shadow_width_map.c_bias");
  bad = good;
  bad.mutable_faces(1)->mutable_view()->set_width(0);
  refused(bad, "shadow_width_map.faces[1].view");
  bad = good;
  bad.mutable_faces(0)->set_max_x(std::nan(""));
  refused(bad, "shadow_width_map.faces[0]");
  bad = good;
  bad.mutable_faces(0)->mutable_view()->mutable_eye()->set_x(0.5);
  refused(bad, "shadow_width_map.faces[0].view");
  bad = good;
  for (int i = 0; i < 2; ++i) {
    bad.mutable_faces(i)->mutable_view()->set_width(8192);
    bad.mutable_faces(i)->mutable_view()->set_height(8192);
  }
  refused(bad, "shadow_width_map.faces");
  bad = good;
  while (bad.faces_size() <= 10) *bad.add_faces() = good.faces(0);
  refused(bad, "shadow_width_map.faces");
}

}  // namespace
}  // namespace penumbra
