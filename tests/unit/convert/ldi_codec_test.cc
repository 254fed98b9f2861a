#include "proto/convert/ldi_codec.h"

#include <gtest/gtest.h>

#include <string>

#include "proto/convert/artifact_assembler.h"
#include "proto/convert/artifact_convert.h"
#include "proto/convert/ldi_convert.h"
#include "render/scene/field_error.h"
#include "tests/support/random_ldi.h"

namespace penumbra {
namespace {

Artifact ArtifactOf(AttenuationLdi ldi) {
  Artifact artifact{.header = {}, .payload = std::move(ldi)};
  artifact.header.light_samples = {{}};
  return artifact;
}

// The update that brings all of the artifact, but for the tiles that `left_out` says so of.
v1::ArtifactUpdate UpdateOf(const Artifact& artifact, uint64_t base,
                            const AttenuationLdi* without = nullptr) {
  const auto& ldi = std::get<AttenuationLdi>(artifact.payload);
  v1::ArtifactUpdate update;
  update.set_base_sequence(base);
  update.set_update_sequence(base + 1);
  *update.mutable_header() = ToProto(artifact);
  update.set_light_samples(EncodeLightSamples(artifact.header.light_samples));
  LdiTileEncoder encoder;
  for (const LdiTilePlace& place : LdiTilesOf(ldi)) {
    if (without && LdiTilesEqual(*without, ldi, place)) continue;
    *update.add_ldi_tiles() = encoder.Encode(ldi, place);
  }
  update.set_end_of_update(true);
  return update;
}

void ExpectSame(const AttenuationLdi& found, const AttenuationLdi& expected) {
  EXPECT_EQ(found.light, expected.light);
  EXPECT_EQ(found.sample_count, expected.sample_count);
  EXPECT_EQ(found.tolerance, expected.tolerance);
  EXPECT_TRUE(HaveSameFaces(found, expected));
  ASSERT_EQ(found.faces.size(), expected.faces.size());
  for (size_t f = 0; f < found.faces.size(); ++f) {
    EXPECT_EQ(found.faces[f].offsets, expected.faces[f].offsets);
    EXPECT_EQ(found.faces[f].depths, expected.faces[f].depths);
    EXPECT_EQ(found.faces[f].counts, expected.faces[f].counts);
  }
}

const AttenuationLdi& LdiOf(const std::optional<ArtifactUpdate>& update) {
  return std::get<AttenuationLdi>(update->artifact->payload);
}

TEST(LdiCodecTest, MapsGoThereAndBack) {
  for (const uint32_t samples : {1u, 255u, 1000u}) {
    const Artifact artifact = ArtifactOf(RandomLdi(samples));
    ArtifactAssembler assembler;
    const auto update = assembler.Add(UpdateOf(artifact, 0));
    ASSERT_TRUE(update.ok()) << update.status();
    ExpectSame(LdiOf(*update), std::get<AttenuationLdi>(artifact.payload));
  }
}

TEST(LdiCodecTest, TilesLeftOutAreAsTheyWere) {
  const AttenuationLdi before = RandomLdi(16);
  AttenuationLdi after = before;
  // A layer of a pixel of the second tile row, and the number of samples with all the rest.
  after.faces[0].counts[after.faces[0].offsets[32 * 70 + 3]] ^= 1;
  after.sample_count = 32;
  ArtifactAssembler assembler;
  ASSERT_TRUE(assembler.Add(UpdateOf(ArtifactOf(before), 0)).ok());
  const v1::ArtifactUpdate difference = UpdateOf(ArtifactOf(after), 1, &before);
  EXPECT_EQ(difference.ldi_tiles_size(), 1);
  const auto update = assembler.Add(difference);
  ASSERT_TRUE(update.ok()) << update.status();
  ExpectSame(LdiOf(*update), after);
}

TEST(LdiCodecTest, AnotherViewStartsFromNothing) {
  const AttenuationLdi before = RandomLdi(16);
  AttenuationLdi after = before;
  after.faces[1].view.eye.x += 1e-9;
  EXPECT_FALSE(HaveSameFaces(before, after));
  ArtifactAssembler assembler;
  ASSERT_TRUE(assembler.Add(UpdateOf(ArtifactOf(before), 0)).ok());
  const auto update = assembler.Add(UpdateOf(ArtifactOf(after), 1, &before));
  EXPECT_EQ(ErrorReason(update.status()), "INCOMPLETE");
}

// Counts of tiles that were left out would be above what they are out of.
TEST(LdiCodecTest, TilesOfMoreSamplesAreNotTakenOver) {
  const Artifact many = ArtifactOf(RandomLdi(200));
  v1::ArtifactUpdate fewer = UpdateOf(many, 1);
  fewer.mutable_header()->mutable_attenuation_ldi()->set_sample_count(3);
  fewer.clear_ldi_tiles();
  ArtifactAssembler assembler;
  ASSERT_TRUE(assembler.Add(UpdateOf(many, 0)).ok());
  const auto status = assembler.Add(fewer).status();
  EXPECT_EQ(ErrorReason(status), "INCOMPLETE") << status;
}

TEST(LdiCodecTest, EmptyMapsGoThereAndBack) {
  AttenuationLdi ldi = RandomLdi(4);
  ldi.faces.clear();
  ArtifactAssembler assembler;
  const auto update = assembler.Add(UpdateOf(ArtifactOf(ldi), 0));
  ASSERT_TRUE(update.ok()) << update.status();
  ExpectSame(LdiOf(*update), ldi);
}

TEST(LdiCodecTest, SurfacesThatGoOnPackWell) {
  AttenuationLdi ldi = RandomLdi(4);
  LdiFace& face = ldi.faces[0];
  face.depths.clear();
  face.counts.assign(70 * 33, 3);
  for (uint32_t p = 0; p < 70 * 33; ++p) {
    face.offsets[p] = p;
    face.depths.push_back(2.0f + 1e-3f * static_cast<float>(p % 70));
  }
  face.offsets.back() = 70 * 33;
  const auto tile = LdiTileEncoder().Encode(ldi, {0, 0, 0});
  EXPECT_LT(tile.ByteSizeLong(), 32u * 32 * 5 / 2);
}

// What a tile that is not right is told.
std::string Fault(void (*spoil)(v1::LdiTile&)) {
  const AttenuationLdi ldi = RandomLdi(300);
  v1::LdiTile tile = LdiTileEncoder().Encode(ldi, {0, 0, 0});
  spoil(tile);
  const absl::Status status = LdiTiles(ldi).Add(tile);
  return ErrorFieldPath(status) + " " + ErrorReason(status);
}

TEST(LdiCodecTest, TilesThatCannotBeAreRefused) {
  using Tile = v1::LdiTile;
  EXPECT_EQ(Fault([](Tile& tile) { tile.set_face(2); }), "ldi_tile RANGE");
  EXPECT_EQ(Fault([](Tile& tile) { tile.set_column(3); }), "ldi_tile RANGE");
  EXPECT_EQ(Fault([](Tile& tile) { tile.set_row(2); }), "ldi_tile RANGE");
  EXPECT_EQ(Fault([](Tile& tile) { tile.set_layers_codec(v1::CODEC_ALL_VISIBLE); }),
            "ldi_tile.layers CODEC");
  EXPECT_EQ(Fault([](Tile& tile) {
              tile.set_layers_codec(v1::CODEC_RAW);
              tile.set_layers(std::string(1024, '\x81'));
            }),
            "ldi_tile.layers RANGE");
  EXPECT_EQ(Fault([](Tile& tile) {
              tile.set_layers_codec(v1::CODEC_RAW);
              tile.set_layers(std::string(1024, '\x1'));
            }),
            "ldi_tile.depths CODEC");  // of another size
  const auto one_layer_each = [](Tile& tile, const std::string& depths) {
    tile.set_layers_codec(v1::CODEC_RAW);
    tile.set_layers(std::string(1023, '\0') + '\x2');
    tile.set_depths_codec(v1::CODEC_RAW);
    tile.set_depths(depths);
  };
  // Bytes of 1.0 and of the difference 0: the second is not further than the first.
  const std::string twice_one("\0\0\0\0\x80\0\x3f\0", 8);
  v1::LdiTile tile = LdiTileEncoder().Encode(RandomLdi(300), {0, 0, 0});
  one_layer_each(tile, twice_one);
  EXPECT_EQ(ErrorFieldPath(LdiTiles(RandomLdi(300)).Add(tile)), "ldi_tile.depths");
  // 1.0 and the next number.
  one_layer_each(tile, std::string("\0\x1\0\0\x80\0\x3f\0", 8));
  tile.set_counts_codec(v1::CODEC_RAW);
  tile.set_counts(std::string("\0\0\x2d\x1", 4));
  EXPECT_EQ(ErrorFieldPath(LdiTiles(RandomLdi(300)).Add(tile)), "ldi_tile.counts");  // 301 of 300
  tile.set_counts(std::string("\0\0\x2c\x1", 4));
  EXPECT_TRUE(LdiTiles(RandomLdi(300)).Add(tile).ok());
}

TEST(LdiConvertTest, ViewsThatCannotBeAreRefused) {
  const auto fault = [](void (*spoil)(v1::AttenuationLdi&)) {
    v1::AttenuationLdi proto = ToProto(RandomLdi(4));
    spoil(proto);
    const absl::Status status = FromProto(proto, SceneLimits{}).status();
    return ErrorFieldPath(status) + " " + ErrorReason(status);
  };
  using Ldi = v1::AttenuationLdi;
  EXPECT_EQ(fault([](Ldi&) {}), " ");
  EXPECT_EQ(fault([](Ldi& ldi) { ldi.set_sample_count(0); }), "attenuation_ldi.sample_count RANGE");
  EXPECT_EQ(fault([](Ldi& ldi) { ldi.set_tolerance(-1); }), "attenuation_ldi.tolerance RANGE");
  EXPECT_EQ(fault([](Ldi& ldi) { ldi.mutable_faces(1)->set_width(20'000); }),
            "attenuation_ldi.faces[1] RANGE");
  EXPECT_EQ(fault([](Ldi& ldi) { ldi.mutable_faces(0)->set_min_x(2); }),
            "attenuation_ldi.faces[0] RANGE");
  EXPECT_EQ(fault([](Ldi& ldi) { ldi.mutable_faces(0)->set_near(1 / 0.0); }),
            "attenuation_ldi.faces[0] NON_FINITE");
}

}  // namespace
}  // namespace penumbra
