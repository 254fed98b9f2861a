#include "proto/convert/artifact_convert.h"

#include <gtest/gtest.h>

#include <limits>
#include <optional>
#include <string>
#include <tuple>
#include <variant>

#include "proto/convert/artifact_assembler.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

Artifact SomeArtifact(uint32_t width = 100, uint32_t height = 70) {
  SoftShadowTexture texture;
  texture.receiver = {.patch = {.origin = {1, 2, 3}, .edge_u = {4, 5, 6}, .edge_v = {7, 8, 9}},
                      .width = width,
                      .height = height,
                      .two_sided = false,
                      .reflectance = {0.1f, 0.2f, 0.3f}};
  texture.light = {"lamp", DiskLight{.center = {0, 3, 0}, .normal = {0, -2, 0}, .radius = 0.25f}};
  texture.visibility = {.width = width,
                        .height = height,
                        .sample_count = 64,
                        .counts = std::vector<uint16_t>(size_t{width} * height)};
  for (size_t i = 0; i < texture.visibility.counts.size(); ++i) {
    texture.visibility.counts[i] = static_cast<uint16_t>(i * i % 65);
  }
  ContentHash hash;
  hash.bytes.fill(0xab);
  return {.header = {.scene_id = "studio",
                     .revision = 41,
                     .scene_hash = hash,
                     .technique = "soft_texture",
                     .light_id = "lamp",
                     .receiver_id = "floor",
                     .parameters = {{"samples", "64"}, {"seed", "1"}},
                     .light_samples = {{{1, 2, 3}, false, 0.25f}, {{0, 1, 0}, true, 0.75f}},
                     .samples_requested = 64,
                     .pass = 2,
                     .is_final = true,
                     .error_estimate = 0.01f,
                     .timings_ms = {{"compute", 1.5}}},
          .payload = std::move(texture)};
}

SoftShadowTexture& TextureOf(Artifact& artifact) {
  return std::get<SoftShadowTexture>(artifact.payload);
}

TEST(ArtifactConvertTest, HeaderGoesThereAndBack) {
  Artifact artifact = SomeArtifact();
  auto back = FromProto(ToProto(artifact));
  ASSERT_TRUE(back.ok()) << back.status();
  const ArtifactHeader& header = back->header;
  EXPECT_EQ(header.scene_id, artifact.header.scene_id);
  EXPECT_EQ(header.revision, artifact.header.revision);
  EXPECT_EQ(header.scene_hash, artifact.header.scene_hash);
  EXPECT_EQ(header.technique, artifact.header.technique);
  EXPECT_EQ(header.light_id, artifact.header.light_id);
  EXPECT_EQ(header.receiver_id, artifact.header.receiver_id);
  EXPECT_EQ(header.parameters, artifact.header.parameters);
  EXPECT_EQ(header.samples_requested, artifact.header.samples_requested);
  EXPECT_EQ(header.pass, artifact.header.pass);
  EXPECT_EQ(header.is_final, artifact.header.is_final);
  EXPECT_EQ(header.error_estimate, artifact.header.error_estimate);
  EXPECT_EQ(header.timings_ms, artifact.header.timings_ms);
  EXPECT_EQ(TextureOf(*back).receiver, TextureOf(artifact).receiver);
  EXPECT_EQ(TextureOf(*back).light, TextureOf(artifact).light);
  EXPECT_EQ(TextureOf(*back).visibility.sample_count, 64u);
  EXPECT_EQ(TextureOf(*back).visibility.counts.size(), 7000u);
  EXPECT_FALSE(TextureOf(*back).radiance);
}

TEST(ArtifactConvertTest, LightSamplesGoThereAndBack) {
  const auto samples = SomeArtifact().header.light_samples;
  const std::string bytes = EncodeLightSamples(samples);
  EXPECT_EQ(bytes.size(), 40u);
  EXPECT_EQ(*DecodeLightSamples(bytes), samples);
  EXPECT_TRUE(DecodeLightSamples("")->empty());
  EXPECT_EQ(ErrorReason(DecodeLightSamples(bytes.substr(1)).status()), "LENGTH");
}

TEST(ArtifactConvertTest, GridsAreCheckedBeforeAnythingIsAllocated) {
  for (const auto& [width, height] :
       {std::pair{0u, 1u}, {1u, 0u}, {16'385u, 1u}, {16'384u, 16'384u}, {~0u, ~0u}}) {
    v1::ArtifactHeader header = ToProto(SomeArtifact());
    header.mutable_soft_shadow_texture()->mutable_receiver()->set_width(width);
    header.mutable_soft_shadow_texture()->mutable_receiver()->set_height(height);
    const auto status = FromProto(header).status();
    EXPECT_EQ(ErrorReason(status), "RANGE") << width << " by " << height << ": " << status;
  }
  v1::ArtifactHeader header = ToProto(SomeArtifact());
  header.mutable_soft_shadow_texture()->set_sample_count(65'536);
  EXPECT_EQ(ErrorReason(FromProto(header).status()), "RANGE");
  header.clear_kind();
  EXPECT_EQ(ErrorReason(FromProto(header).status()), "MISSING_FIELD");
}

// Found by fuzz_texture_updates: points have no texel on such a receiver.
TEST(ArtifactConvertTest, AReceiverHasAnArea) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::string patch = "soft_shadow_texture.receiver.patch.";
  for (const auto& [wrong, reason, field] :
       {std::tuple{Parallelogram{.edge_u = Vec3(0)}, "ZERO_AREA", "edge_u"},
        {{.edge_u = {1, 2, 3}, .edge_v = {2, 4, 6.0000005f}}, "ZERO_AREA", "edge_v"},
        {{.origin = {0, nan, 0}}, "NON_FINITE", "origin"},
        {{.edge_v = {1, nan, 0}}, "NON_FINITE", "edge_v"}}) {
    Artifact artifact = SomeArtifact();
    TextureOf(artifact).receiver.patch = wrong;
    const auto status = FromProto(ToProto(artifact)).status();
    EXPECT_EQ(ErrorReason(status), reason) << status;
    EXPECT_EQ(ErrorFieldPath(status), patch + field);
  }
  Artifact far = SomeArtifact();
  TextureOf(far).receiver.patch.origin = Vec3(2e9f);  // as of an instance whose box reaches so far
  EXPECT_EQ(FromProto(ToProto(far)).status(), absl::OkStatus());
}

v1::ArtifactUpdate WholeUpdate(const Artifact& artifact, uint64_t sequence) {
  v1::ArtifactUpdate update;
  update.set_update_sequence(sequence);
  update.set_revision(artifact.header.revision);
  *update.mutable_header() = ToProto(artifact);
  update.set_light_samples(EncodeLightSamples(artifact.header.light_samples));
  const auto& texture = std::get<SoftShadowTexture>(artifact.payload);
  const TileGrid grid = GridOf(texture);
  TileEncoder encoder;
  for (uint32_t row = 0; row < grid.rows(); ++row) {
    for (uint32_t column = 0; column < grid.columns(); ++column) {
      *update.add_tiles() = encoder.Encode(texture, column, row);
    }
  }
  update.set_end_of_update(true);
  return update;
}

TEST(ArtifactAssemblerTest, PutsPiecesTogether) {
  Artifact artifact = SomeArtifact();
  const v1::ArtifactUpdate whole = WholeUpdate(artifact, 3);
  ArtifactAssembler assembler;
  v1::ArtifactUpdate piece = whole;
  piece.clear_tiles();
  piece.set_end_of_update(false);
  EXPECT_FALSE(assembler.Add(piece)->has_value());
  for (int i = 0; i < whole.tiles_size(); ++i) {
    piece = v1::ArtifactUpdate();
    piece.set_update_sequence(3);
    *piece.add_tiles() = whole.tiles(i);
    piece.set_end_of_update(i + 1 == whole.tiles_size());
    const auto update = assembler.Add(piece);
    ASSERT_TRUE(update.ok()) << update.status();
    ASSERT_EQ(update->has_value(), piece.end_of_update());
    if (!update->has_value()) continue;
    EXPECT_EQ(TextureOf(const_cast<Artifact&>(*(*update)->artifact)).visibility.counts,
              TextureOf(artifact).visibility.counts);
    EXPECT_EQ((*update)->artifact->header.light_samples, artifact.header.light_samples);
    EXPECT_EQ((*update)->revision, 41u);
  }
  EXPECT_EQ(assembler.sequence(), 3u);
}

// Found by fuzz_layer_updates: whoever was told had neither an error nor an artifact.
TEST(ArtifactAssemblerTest, AnErrorOfNoCodeIsNone) {
  v1::ArtifactUpdate update;
  update.set_revision(1);
  update.mutable_error();
  update.set_end_of_update(true);
  ArtifactAssembler assembler;
  EXPECT_EQ(ErrorReason(assembler.Add(update).status()), "INCOMPLETE");
}

TEST(ArtifactAssemblerTest, KeepsWhatIsLeftOut) {
  Artifact artifact = SomeArtifact();
  ArtifactAssembler assembler;
  const auto first = assembler.Add(WholeUpdate(artifact, 1));
  TextureOf(artifact).visibility.counts[0] ^= 1;  // in the first tile
  artifact.header.revision = 42;
  v1::ArtifactUpdate change = WholeUpdate(artifact, 2);
  change.set_base_sequence(1);
  change.clear_light_samples();
  change.mutable_tiles()->DeleteSubrange(1, change.tiles_size() - 1);
  const auto second = assembler.Add(change);
  ASSERT_TRUE(second.ok()) << second.status();
  EXPECT_EQ(std::get<SoftShadowTexture>((*second)->artifact->payload).visibility.counts,
            TextureOf(artifact).visibility.counts);
  EXPECT_NE(std::get<SoftShadowTexture>((*first)->artifact->payload).visibility.counts,
            TextureOf(artifact).visibility.counts)
      << "what was handed out stays as it was";
  EXPECT_EQ((*second)->artifact->header.light_samples.size(), 2u);

  v1::ArtifactUpdate news;
  news.set_revision(43);
  news.set_update_sequence(2);
  news.set_end_of_update(true);
  const auto third = assembler.Add(news);
  EXPECT_EQ((*third)->artifact, (*second)->artifact);
  EXPECT_EQ((*third)->revision, 43u);

  news.mutable_error()->set_code(5);
  EXPECT_EQ((*assembler.Add(news))->status.code(), absl::StatusCode::kNotFound);
  news.clear_error();
  EXPECT_EQ((*assembler.Add(news))->artifact, (*second)->artifact) << "the error has gone";
}

TEST(ArtifactAssemblerTest, WhatDoesNotAddUpIsAnError) {
  const v1::ArtifactUpdate whole = WholeUpdate(SomeArtifact(), 1);
  v1::ArtifactUpdate bad = whole;
  bad.mutable_tiles()->RemoveLast();
  EXPECT_EQ(ErrorReason(ArtifactAssembler().Add(bad).status()), "INCOMPLETE");
  bad = whole;
  ASSERT_GT(bad.tiles_size(), 1);
  *bad.mutable_tiles(1) = bad.tiles(0);  // as many as there have to be
  EXPECT_EQ(ErrorReason(ArtifactAssembler().Add(bad).status()), "INCOMPLETE");
  bad = whole;
  bad.clear_header();
  EXPECT_EQ(ErrorReason(ArtifactAssembler().Add(bad).status()), "INCOMPLETE");
  bad = whole;
  bad.clear_light_samples();
  EXPECT_EQ(ErrorReason(ArtifactAssembler().Add(bad).status()), "INCOMPLETE");
  bad = v1::ArtifactUpdate();
  bad.set_end_of_update(true);
  EXPECT_EQ(ErrorReason(ArtifactAssembler().Add(bad).status()), "INCOMPLETE");
}

}  // namespace
}  // namespace penumbra
