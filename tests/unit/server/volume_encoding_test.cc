// What of a shadow volume mesh is encoded again after an edit, and what a client makes of it.
#include <gtest/gtest.h>

#include <set>
#include <string>
#include <utility>
#include <vector>

#include "proto/convert/artifact_assembler.h"
#include "server/session/encoded_artifact.h"
#include "tests/support/random_volume_mesh.h"

namespace penumbra {
namespace {

using testing::RandomVolume;
using Volumes = std::vector<std::shared_ptr<const ShadowVolume>>;

std::shared_ptr<const Artifact> ArtifactOf(Volumes volumes) {
  Artifact artifact{.header = {},
                    .payload = ShadowVolumeMesh{.light = {.id = "l", .shape = PointLight{}},
                                                .volumes = std::move(volumes)}};
  artifact.header.light_samples = {{}};
  return std::make_shared<Artifact>(std::move(artifact));
}

std::shared_ptr<const ShadowVolume> Volume(uint32_t seed, uint32_t triangles) {
  return std::make_shared<ShadowVolume>(RandomVolume(seed, triangles, VolumeKind::kReconstructed));
}

size_t ChangedTiles(const EncodedArtifact& encoded) {
  size_t count = 0;
  for (const EncodedTile& tile : encoded.tiles) count += tile.changed_at == encoded.sequence;
  return count;
}

// All that is newer than `base`, as one message.
v1::ArtifactUpdate UpdateSince(const EncodedArtifact& encoded, uint64_t base) {
  std::string bytes;
  const auto append = [&](const grpc::Slice& slice) {
    bytes.append(reinterpret_cast<const char*>(slice.begin()), slice.size());
  };
  append(encoded.header);
  append(encoded.light_samples);
  for (const EncodedTile& tile : encoded.tiles) {
    if (tile.changed_at > base) append(tile.bytes);
  }
  v1::ArtifactUpdate update;
  EXPECT_TRUE(update.ParseFromString(bytes));
  update.set_base_sequence(base);
  update.set_update_sequence(encoded.sequence);
  update.set_end_of_update(true);
  return update;
}

void ExpectIs(const absl::StatusOr<std::optional<ArtifactUpdate>>& update,
              const Artifact& expected) {
  ASSERT_TRUE(update.ok()) << update.status();
  const auto& found = std::get<ShadowVolumeMesh>((*update)->artifact->payload).volumes;
  const auto& wanted = std::get<ShadowVolumeMesh>(expected.payload).volumes;
  ASSERT_EQ(found.size(), wanted.size());
  for (size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i]->content, wanted[i]->content);
    EXPECT_EQ(found[i]->vertices, wanted[i]->vertices);
    EXPECT_EQ(found[i]->indices, wanted[i]->indices);
  }
}

TEST(VolumeEncodingTest, WhatDidNotChangeKeepsItsNumber) {
  ArtifactEncoder encoder;
  const auto a = Volume(1, 9000), b = Volume(2, 500), c = Volume(3, 300);
  const auto first = encoder.Encode(nullptr, ArtifactOf({a, b}), 1);
  EXPECT_EQ(ChangedTiles(*first), first->tiles.size());
  // Nothing is new but the order.
  const auto turned = encoder.Encode(first.get(), ArtifactOf({b, a}), 2);
  EXPECT_EQ(ChangedTiles(*turned), 0u);
  // One sample of a copy: its tile, and the head that names it.
  auto edited = std::make_shared<ShadowVolume>(*a);
  edited->faces[0].map.depths[5] = 0.5f;
  const auto second = encoder.Encode(turned.get(), ArtifactOf({b, edited, c}), 3);
  size_t of_c = PartsOf(*c).size();
  EXPECT_EQ(ChangedTiles(*second), 2 + of_c);
  // Away and back again: new for who has not seen it since.
  const auto without = encoder.Encode(second.get(), ArtifactOf({b}), 4);
  EXPECT_EQ(ChangedTiles(*without), 0u);
  const auto again = encoder.Encode(without.get(), ArtifactOf({b, c}), 5);
  EXPECT_EQ(ChangedTiles(*again), of_c);
}

// A client that takes every update, and one that skips some, come to the same.
TEST(VolumeEncodingTest, UpdatesMayBeSkipped) {
  ArtifactEncoder encoder;
  const auto a = Volume(4, 3000), b = Volume(5, 2000), c = Volume(6, 1000);
  const std::vector<std::shared_ptr<const Artifact>> states = {
      ArtifactOf({a, b}),    ArtifactOf({b}), ArtifactOf({b, c}),
      ArtifactOf({a, c, b}), ArtifactOf({}),  ArtifactOf({c})};
  ArtifactAssembler quick, slow;
  std::shared_ptr<const EncodedArtifact> encoded;
  uint64_t slow_has = 0;
  for (size_t i = 0; i < states.size(); ++i) {
    encoded = encoder.Encode(encoded.get(), states[i], i + 1);
    ExpectIs(quick.Add(UpdateSince(*encoded, i)), *states[i]);
    if (i % 2 == 1) continue;
    ExpectIs(slow.Add(UpdateSince(*encoded, slow_has)), *states[i]);
    slow_has = i + 1;
    // An error between is none of what is held.
    v1::ArtifactUpdate error;
    error.mutable_error()->set_code(8);
    error.set_update_sequence(slow_has);
    error.set_end_of_update(true);
    EXPECT_TRUE(slow.Add(error).ok());
  }
}

// A strip of triangles all at one place, where a part ends as soon as it may.
ShadowVolume ManyParts(uint32_t triangles) {
  ShadowVolume volume = RandomVolume(7, triangles, VolumeKind::kReconstructed);
  for (float x = 1;; ++x) {
    ShadowVolume few = RandomVolume(7, 640, VolumeKind::kReconstructed);
    few.faces.clear();
    few.vertices.assign(few.vertices.size(), Vec4(x, 0, 0, 1));
    if (PartsOf(few).size() < 10) continue;
    volume.vertices.assign(volume.vertices.size(), few.vertices[0]);
    return volume;
  }
}

// More volumes, and more parts of one, than a list of names has.
TEST(VolumeEncodingTest, ManyNamesComeInLists) {
  ArtifactEncoder encoder;
  Volumes many;
  for (uint32_t i = 0; i < 5000; ++i) {
    auto small = std::make_shared<ShadowVolume>(RandomVolume(i, 2, VolumeKind::kObject));
    small->instance_id = "thing" + std::to_string(i);
    many.push_back(std::move(small));
  }
  const auto large = std::make_shared<ShadowVolume>(ManyParts(300'000));
  EXPECT_GT(PartsOf(*large).size(), kMaxNamesOfAList);
  for (const auto& artifact : {ArtifactOf(many), ArtifactOf({large})}) {
    const auto encoded = encoder.Encode(nullptr, artifact, 1);
    EXPECT_LT(encoded->header.size(), size_t{2000});
    for (const EncodedTile& tile : encoded->tiles) EXPECT_LT(tile.bytes.size(), size_t{1} << 18);
    ExpectIs(ArtifactAssembler().Add(UpdateSince(*encoded, 0)), *artifact);
    const auto again = encoder.Encode(encoded.get(), artifact, 2);
    EXPECT_EQ(ChangedTiles(*again), 0u);
  }
}

}  // namespace
}  // namespace penumbra
