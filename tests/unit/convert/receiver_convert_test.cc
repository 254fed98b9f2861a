// Receivers of every shape, and masks, over the wire.
#include <gtest/gtest.h>
#include <zstd.h>

#include <optional>
#include <random>
#include <string>

#include "proto/convert/artifact_assembler.h"
#include "proto/convert/artifact_convert.h"
#include "proto/convert/coverage_codec.h"
#include "proto/convert/scene_convert.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

TEST(ReceiverConvertTest, EveryShapeGoesThereAndBack) {
  for (const ReceiverShape& shape :
       {ReceiverShape(Parallelogram{{1, 2, 3}, {4, 5, 6}, {7, 8, 9}}),
        ReceiverShape(PlanarInstance{"table"}),
        ReceiverShape(Triangle{{1, 2, 3}, {4, 5, 6}, {7, 8, 9}}),
        ReceiverShape(PlanarPolygon{{{1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {10, 11, 12}}}),
        ReceiverShape(PlanarSurface{"table", 17})}) {
    for (const uint32_t side : {0u, 9u}) {
      const Receiver receiver{.id = "r",
                              .shape = shape,
                              .width = side,
                              .height = 2 * side,
                              .two_sided = false,
                              .reflectance = {0.1f, 0.2f, 0.3f},
                              .texels_per_metre = 12.5f,
                              .max_auto_side = 77};
      const auto back = FromProto(ToProto(receiver), "upsert_receivers[3]");
      ASSERT_TRUE(back.ok()) << back.status();
      EXPECT_EQ(*back, receiver);
    }
  }
  v1::Receiver odd;
  odd.mutable_polygon()->add_vertices(1);
  const auto status = FromProto(odd, "upsert_receivers[3]").status();
  EXPECT_EQ(ErrorReason(status), "LENGTH");
  EXPECT_EQ(ErrorFieldPath(status), "upsert_receivers[3].vertices");
}

TEST(ReceiverConvertTest, ARequestForSurfacesGoesThereAndBack) {
  const PlanarSurfaceRequest request{.min_area_m2 = 0.25,
                                     .max_receivers = 9,
                                     .texels_per_metre = 20,
                                     .max_auto_side = 128,
                                     .id_prefix = "p."};
  EXPECT_EQ(FromProto(ToProto(request)), request);
  EXPECT_EQ(FromProto(v1::ReceiveOnPlanarSurfaces()), PlanarSurfaceRequest());
}

CoverageMask RandomMask(uint32_t width, uint32_t height, uint32_t seed) {
  CoverageMask mask(width, height);
  std::mt19937 random(seed);
  for (size_t k = 0; k < mask.texel_count(); ++k) {
    if (random() % 3 == 0) mask.Set(k);
  }
  return mask;
}

TEST(CoverageCodecTest, MasksGoThereAndBack) {
  for (const auto& [width, height] : {std::pair{1u, 1u}, {3u, 5u}, {64u, 64u}, {1000u, 1100u}}) {
    const CoverageMask mask = RandomMask(width, height, width);
    CoverageMask back(width, height);
    EXPECT_EQ(CoveragePartCount(mask), width == 1000 ? 3u : 1u);
    for (uint32_t i = 0; i < CoveragePartCount(mask); ++i) {
      ASSERT_TRUE(DecodePart(EncodePart(mask, i), back).ok());
      EXPECT_TRUE(CoveragePartsEqual(mask, back, i));
    }
    EXPECT_EQ(back, mask);
  }
  CoverageMask half(256, 256);
  for (size_t k = 0; k < half.texel_count() / 2; ++k) half.Set(k);
  EXPECT_LT(EncodePart(half, 0).bits().size(), 100u) << "8 KiB of it";
}

TEST(CoverageCodecTest, BadPartsAreErrors) {
  CoverageMask mask(3, 5);
  const auto reason = [&](v1::Codec codec, uint32_t index, const std::string& bits) {
    v1::CoveragePart part;
    part.set_codec(codec);
    part.set_index(index);
    part.set_bits(bits);
    const auto status = DecodePart(part, mask);
    EXPECT_EQ(ErrorFieldPath(status), "coverage");
    return ErrorReason(status);
  };
  std::string bomb(ZSTD_compressBound(1 << 24), '\0');
  const std::string zeros(1 << 24, '\0');
  bomb.resize(ZSTD_compress(bomb.data(), bomb.size(), zeros.data(), zeros.size(), 1));
  EXPECT_EQ(reason(v1::CODEC_RAW, 1, "ab"), "RANGE");
  EXPECT_EQ(reason(v1::CODEC_RAW, 0, "abc"), "LENGTH");
  EXPECT_EQ(reason(v1::CODEC_RAW, 0, std::string("\0\x80", 2)), "RANGE") << "the sixteenth of 15";
  EXPECT_EQ(reason(v1::CODEC_ALL_VISIBLE, 0, ""), "CODEC");
  EXPECT_EQ(reason(v1::CODEC_ZSTD, 0, "no frame"), "CODEC");
  EXPECT_EQ(reason(v1::CODEC_ZSTD, 0, bomb), "CODEC");
}

Artifact MaskedArtifact(uint32_t width, uint32_t height,
                        std::shared_ptr<const CoverageMask> coverage) {
  SoftShadowTexture texture;
  texture.receiver = {.patch = {}, .width = width, .height = height};
  texture.light = {"lamp", PointLight{}};
  texture.visibility = {.width = width,
                        .height = height,
                        .sample_count = 4,
                        .counts = std::vector<uint16_t>(size_t{width} * height)};
  texture.coverage = std::move(coverage);
  Artifact artifact;
  artifact.payload = std::move(texture);
  return artifact;
}

v1::ArtifactUpdate Update(const Artifact& artifact, uint64_t sequence, uint64_t base,
                          bool with_coverage) {
  const auto& texture = std::get<SoftShadowTexture>(artifact.payload);
  v1::ArtifactUpdate update;
  update.set_update_sequence(sequence);
  update.set_base_sequence(base);
  *update.mutable_header() = ToProto(artifact);
  update.set_light_samples("");
  TileEncoder encoder;
  *update.add_tiles() = encoder.Encode(texture, 0, 0);
  if (with_coverage) *update.add_coverage() = EncodePart(*texture.coverage, 0);
  update.set_end_of_update(true);
  return update;
}

TEST(ArtifactAssemblerTest, KeepsAMaskUntilItChanges) {
  const auto first = std::make_shared<CoverageMask>(RandomMask(20, 30, 1));
  const auto second = std::make_shared<CoverageMask>(RandomMask(20, 30, 2));
  ArtifactAssembler assembler;
  const auto mask_after = [&](const v1::ArtifactUpdate& update) {
    auto result = assembler.Add(update);
    EXPECT_TRUE(result.ok()) << result.status();
    return std::get<SoftShadowTexture>((**result).artifact->payload).coverage;
  };
  const auto held = mask_after(Update(MaskedArtifact(20, 30, first), 1, 0, true));
  EXPECT_EQ(*held, *first);
  EXPECT_EQ(mask_after(Update(MaskedArtifact(20, 30, first), 2, 1, false)), held);
  EXPECT_EQ(*mask_after(Update(MaskedArtifact(20, 30, second), 3, 2, true)), *second);
  EXPECT_EQ(*held, *first) << "what was handed out stays as it was";
  EXPECT_EQ(mask_after(Update(MaskedArtifact(20, 30, nullptr), 4, 3, false)), nullptr);
  const auto missing = assembler.Add(Update(MaskedArtifact(20, 30, first), 5, 4, false));
  EXPECT_EQ(ErrorReason(missing.status()), "INCOMPLETE");
  v1::ArtifactUpdate unasked = Update(MaskedArtifact(20, 30, nullptr), 1, 0, false);
  *unasked.add_coverage() = EncodePart(*first, 0);
  EXPECT_EQ(ErrorReason(ArtifactAssembler().Add(unasked).status()), "INCOMPLETE");
}

}  // namespace
}  // namespace penumbra
