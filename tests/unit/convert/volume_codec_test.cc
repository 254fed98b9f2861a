#include "proto/convert/volume_codec.h"

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>
#include <random>
#include <set>
#include <string>

#include "proto/convert/artifact_assembler.h"
#include "proto/convert/artifact_convert.h"
#include "render/artifact/volume_cap.h"
#include "render/scene/field_error.h"
#include "tests/support/random_volume_mesh.h"

namespace penumbra {
namespace {

using testing::RandomVolume;

Artifact ArtifactOf(std::vector<ShadowVolume> volumes) {
  ShadowVolumeMesh mesh{.light = {.id = "l", .shape = PointLight{.position = Vec3(1, 2, 3)}},
                        .bias_px = 0.5f,
                        .volumes = {},
                        .edge_fraction = 0.125f};
  for (ShadowVolume& volume : volumes) {
    mesh.volumes.push_back(std::make_shared<ShadowVolume>(std::move(volume)));
  }
  Artifact artifact{.header = {}, .payload = std::move(mesh)};
  artifact.header.light_samples = {{}};
  return artifact;
}

const ShadowVolumeMesh& MeshOf(const Artifact& artifact) {
  return std::get<ShadowVolumeMesh>(artifact.payload);
}
const ShadowVolumeMesh& MeshOf(const std::optional<ArtifactUpdate>& update) {
  return MeshOf(*update->artifact);
}

// The update that brings all of the artifact, but for parts that are in `held`.
v1::ArtifactUpdate UpdateOf(const Artifact& artifact, uint64_t base,
                            const std::set<std::string>& held = {}) {
  v1::ArtifactUpdate update;
  update.set_base_sequence(base);
  update.set_update_sequence(base + 1);
  *update.mutable_header() = ToProto(artifact);
  update.set_light_samples(EncodeLightSamples(artifact.header.light_samples));
  VolumePartEncoder encoder;
  for (const auto& volume : MeshOf(artifact).volumes) {
    const std::vector<VolumePartPlan> parts = PartsOf(*volume);
    update.mutable_header()->mutable_shadow_volume_mesh()->add_volumes(parts.front().name);
    for (const VolumePartPlan& part : parts) {
      if (!held.contains(part.name)) *update.add_volume_parts() = encoder.Encode(*volume, part);
    }
  }
  update.set_end_of_update(true);
  return update;
}

std::set<std::string> NamesOf(const Artifact& artifact) {
  std::set<std::string> names;
  for (const auto& volume : MeshOf(artifact).volumes) {
    for (const VolumePartPlan& part : PartsOf(*volume)) names.insert(part.name);
  }
  return names;
}

void ExpectSame(const ShadowVolume& found, const ShadowVolume& expected) {
  EXPECT_EQ(found.instance_id, expected.instance_id);
  EXPECT_EQ(found.content, expected.content);
  EXPECT_EQ(found.kind, expected.kind);
  ASSERT_EQ(found.faces.size(), expected.faces.size());
  for (size_t f = 0; f < found.faces.size(); ++f) {
    EXPECT_TRUE(IsSameView(found.faces[f].map.view, expected.faces[f].map.view));
    EXPECT_EQ(found.faces[f].map.depths, expected.faces[f].map.depths);
    EXPECT_EQ(found.faces[f].border, expected.faces[f].border);
  }
  EXPECT_EQ(found.vertices, expected.vertices);
  EXPECT_EQ(found.indices, expected.indices);
  EXPECT_EQ(found.weights, expected.weights);
  EXPECT_EQ(found.caster_indices, expected.caster_indices);
}

void ExpectSame(const ShadowVolumeMesh& found, const ShadowVolumeMesh& expected) {
  EXPECT_EQ(found.light, expected.light);
  EXPECT_EQ(found.bias_px, expected.bias_px);
  EXPECT_EQ(found.edge_fraction, expected.edge_fraction);
  ASSERT_EQ(found.volumes.size(), expected.volumes.size());
  for (size_t i = 0; i < found.volumes.size(); ++i) {
    ExpectSame(*found.volumes[i], *expected.volumes[i]);
  }
}

TEST(VolumeCodecTest, MeshesGoThereAndBack) {
  ShadowVolume unordered = RandomVolume(3, 5000, VolumeKind::kVectorized);
  std::mt19937 random(4);
  for (uint32_t& index : unordered.indices) {
    index = static_cast<uint32_t>(random() % unordered.vertices.size());
  }
  unordered.vertices.resize(15'000, Vec4(1));  // many that no triangle has
  for (const Artifact& artifact :
       {ArtifactOf({}), ArtifactOf({RandomVolume(1, 20'000, VolumeKind::kReconstructed)}),
        ArtifactOf({RandomVolume(2, 700, VolumeKind::kObject),
                    RandomVolume(2, 0, VolumeKind::kReconstructed), std::move(unordered)})}) {
    ArtifactAssembler assembler;
    const auto update = assembler.Add(UpdateOf(artifact, 0));
    ASSERT_TRUE(update.ok()) << update.status();
    ExpectSame(MeshOf(*update), MeshOf(artifact));
  }
}

TEST(VolumeCodecTest, PartsLeftOutAreAsTheyWere) {
  const ShadowVolume whole = RandomVolume(5, 20'000, VolumeKind::kReconstructed);
  ShadowVolume edited = whole;
  // One sample, and some triangles in the middle that shift all that follow.
  edited.faces[0].map.depths[7] = 0.75f;
  edited.indices.erase(edited.indices.begin() + 30'000, edited.indices.begin() + 30'030);
  const ShadowVolume other = RandomVolume(6, 300, VolumeKind::kObject);
  const Artifact before = ArtifactOf({whole, other}), after = ArtifactOf({edited, other});
  ArtifactAssembler assembler;
  const auto first = assembler.Add(UpdateOf(before, 0));
  ASSERT_TRUE(first.ok()) << first.status();
  const v1::ArtifactUpdate difference = UpdateOf(after, 1, NamesOf(before));
  // The head, a tile of depths, and the triangles around the gap.
  EXPECT_LE(difference.volume_parts_size(), 4);
  EXPECT_GT(NamesOf(before).size(), 40u);
  const auto second = assembler.Add(difference);
  ASSERT_TRUE(second.ok()) << second.status();
  ExpectSame(MeshOf(*second), MeshOf(after));
  EXPECT_EQ(MeshOf(*second).volumes[1], MeshOf(*first).volumes[1]) << "shared, not made again";
}

TEST(VolumeCodecTest, WhatIsMissingIsTold) {
  const Artifact artifact = ArtifactOf({RandomVolume(7, 2000, VolumeKind::kReconstructed)});
  const v1::ArtifactUpdate whole = UpdateOf(artifact, 0);
  for (int part = 1; part < whole.volume_parts_size(); part += 3) {
    v1::ArtifactUpdate lacking = whole;
    lacking.mutable_volume_parts()->DeleteSubrange(part, 1);
    ArtifactAssembler assembler;
    EXPECT_EQ(assembler.Add(lacking).status().code(), absl::StatusCode::kDataLoss) << part;
  }
  ArtifactAssembler assembler;  // what was held before does not count where all is said to come
  ASSERT_TRUE(assembler.Add(whole).ok());
  EXPECT_EQ(assembler.Add(UpdateOf(artifact, 0, NamesOf(artifact))).status().code(),
            absl::StatusCode::kDataLoss);
}

// What is wrong in an update, and the field that the error names.
struct Wrong {
  const char* field;
  void (*spoil)(v1::ArtifactUpdate& update);
};

v1::VolumeTriangles& TrianglesOf(v1::ArtifactUpdate& update) {
  for (auto& part : *update.mutable_volume_parts()) {
    if (part.has_triangles() && part.triangles().corners_size() > 0)
      return *part.mutable_triangles();
  }
  throw std::logic_error("no triangles");
}

v1::VolumeHead& HeadOf(v1::ArtifactUpdate& update) {
  return *update.mutable_volume_parts(0)->mutable_head();
}

constexpr Wrong kWrong[] = {
    {"shadow_volume_mesh.bias_px",
     [](auto& u) { u.mutable_header()->mutable_shadow_volume_mesh()->set_bias_px(NAN); }},
    {"shadow_volume_mesh.edge_fraction",
     [](auto& u) { u.mutable_header()->mutable_shadow_volume_mesh()->set_edge_fraction(2); }},
    {"shadow_volume_mesh.volumes",
     [](auto& u) { u.mutable_header()->mutable_shadow_volume_mesh()->set_volumes(0, "short"); }},
    {"volume_part.name", [](auto& u) { u.mutable_volume_parts(1)->set_name("somebody else's"); }},
    {"volume_part.head.kind", [](auto& u) { HeadOf(u).set_kind(static_cast<v1::VolumeKind>(9)); }},
    {"volume_part.head.content", [](auto& u) { HeadOf(u).set_content("x"); }},
    {"volume_part.head.parts", [](auto& u) { HeadOf(u).add_parts("x"); }},
    {"volume_part.head.faces[0].view",
     [](auto& u) { HeadOf(u).mutable_faces(0)->mutable_view()->set_width(1u << 30); }},
    {"volume_part.head.faces[1].border",
     [](auto& u) { HeadOf(u).mutable_faces(1)->clear_border(); }},
    {"volume_part.depths",
     [](auto& u) { u.mutable_volume_parts(1)->mutable_depths()->set_face(5); }},
    {"volume_part.depths.depths",
     [](auto& u) {
       u.mutable_volume_parts(1)->mutable_depths()->mutable_depths()->set_packed("?");
     }},
    {"volume_part.content", [](auto& u) { u.mutable_volume_parts(1)->clear_content(); }},
    {"volume_part.triangles.corners", [](auto& u) { TrianglesOf(u).set_corners(2, 0); }},
    {"volume_part.triangles.corners", [](auto& u) { TrianglesOf(u).set_corners(2, ~0u); }},
    {"volume_part.triangles.corners", [](auto& u) { TrianglesOf(u).add_corners(1); }},
    {"volume_part.triangles.vertex_count",
     [](auto& u) { TrianglesOf(u).set_vertex_count(1u << 31); }},
    {"volume_part.triangles", [](auto& u) { TrianglesOf(u).add_weights(1); }},
    {"volume_part.triangles", [](auto& u) { TrianglesOf(u).set_are_the_casters(true); }},
    {"volume_part.head.instance_id", [](auto& u) { HeadOf(u).set_instance_id("a\nb"); }},
    {"volume_part.head.faces", [](auto& u) { HeadOf(u).clear_faces(); }},
    {"volume_part.head.faces",
     [](auto& u) { HeadOf(u).mutable_faces(0)->mutable_view()->set_from_infinity(true); }},
    {"shadow_volume_mesh.volumes",
     [](auto& u) {
       auto& mesh = *u.mutable_header()->mutable_shadow_volume_mesh();
       mesh.add_volumes(mesh.volumes(0));
     }},
};

TEST(VolumeCodecTest, WhatCannotBeIsRefused) {
  const v1::ArtifactUpdate whole =
      UpdateOf(ArtifactOf({RandomVolume(8, 300, VolumeKind::kReconstructed)}), 0);
  ASSERT_TRUE(ArtifactAssembler().Add(whole).ok());
  for (const Wrong& wrong : kWrong) {
    v1::ArtifactUpdate update = whole;
    wrong.spoil(update);
    const absl::Status status = ArtifactAssembler().Add(update).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << wrong.field << ": " << status;
    EXPECT_EQ(ErrorFieldPath(status), wrong.field) << status;
  }
}

// Of an object: weights that are none or too many, and casters infinitely far.
TEST(VolumeCodecTest, WhatAnObjectCannotHaveIsRefused) {
  const v1::ArtifactUpdate whole =
      UpdateOf(ArtifactOf({RandomVolume(8, 300, VolumeKind::kObject)}), 0);
  for (void (*spoil)(v1::VolumeTriangles&) :
       {+[](v1::VolumeTriangles& t) { t.set_weights(0, 128); },
        +[](v1::VolumeTriangles& t) { t.add_weights(1); }}) {
    v1::ArtifactUpdate update = whole;
    spoil(TrianglesOf(update));
    EXPECT_EQ(ErrorFieldPath(ArtifactAssembler().Add(update).status()),
              "volume_part.triangles.weights");
  }
  ShadowVolume far_caster = RandomVolume(8, 300, VolumeKind::kObject);
  far_caster.caster_indices[0] = 4;
  EXPECT_EQ(ErrorFieldPath(ArtifactAssembler().Add(UpdateOf(ArtifactOf({far_caster}), 0)).status()),
            "volume_part.triangles.corners");
}

// Not a number, infinite, or behind the projection.
TEST(VolumeCodecTest, VerticesThatAreNoPlacesAreRefused) {
  for (const Vec4 vertex : {Vec4(NAN, 0, 0, 1), Vec4(0, INFINITY, 0, 1), Vec4(0, 0, 0, -1), Vec4(0),
                            Vec4(1e30f, 0, 0, 1e-30f)}) {
    ShadowVolume volume = RandomVolume(9, 100, VolumeKind::kReconstructed);
    volume.vertices[50] = vertex;
    const auto status = ArtifactAssembler().Add(UpdateOf(ArtifactOf({volume}), 0)).status();
    EXPECT_EQ(ErrorFieldPath(status), "volume_part.triangles.vertices") << status;
  }
  ShadowVolume volume = RandomVolume(9, 100, VolumeKind::kReconstructed);
  volume.faces[0].map.depths[5] = NAN;
  const auto status = ArtifactAssembler().Add(UpdateOf(ArtifactOf({volume}), 0)).status();
  EXPECT_EQ(ErrorFieldPath(status), "volume_part.depths.depths") << status;
}

// More samples, of one volume or of all, than the limits allow.
TEST(VolumeCodecTest, LimitsHold) {
  SceneLimits limits;
  limits.max_receiver_texels = 150 * 70 + 64 * 64;
  const ShadowVolume volume = RandomVolume(10, 10, VolumeKind::kReconstructed);
  EXPECT_TRUE(ArtifactAssembler(limits).Add(UpdateOf(ArtifactOf({volume}), 0)).ok());
  const auto two = ArtifactAssembler(limits)
                       .Add(UpdateOf(ArtifactOf({volume, RandomVolume(11, 10, volume.kind)}), 0))
                       .status();
  EXPECT_EQ(ErrorFieldPath(two), "shadow_volume_mesh.volumes") << two;
  limits.max_receiver_texels -= 1;
  EXPECT_FALSE(ArtifactAssembler(limits).Add(UpdateOf(ArtifactOf({volume}), 0)).ok());
}

// No update, however its bytes were changed, does worse than being refused; what is taken can be
// looked up in and capped.
TEST(VolumeCodecTest, ChangedBytesDoNoHarm) {
  const std::string bytes = UpdateOf(ArtifactOf({RandomVolume(12, 40, VolumeKind::kObject),
                                                 RandomVolume(13, 60, VolumeKind::kReconstructed)}),
                                     0)
                                .SerializeAsString();
  SceneLimits limits;
  limits.max_receiver_texels = 1 << 18;
  std::mt19937 random(14);
  int taken = 0;
  for (int turn = 0; turn < 4000; ++turn) {
    std::string changed = bytes;
    for (int i = 0; i < 1 + turn % 3; ++i) {
      changed[random() % changed.size()] = static_cast<char>(random());
    }
    v1::ArtifactUpdate proto;
    if (!proto.ParseFromString(changed)) continue;
    const auto update = ArtifactAssembler(limits).Add(proto);
    if (!update.ok() || !*update || !(*update)->artifact) continue;
    ++taken;
    const ShadowVolumeMesh& mesh = MeshOf(*update);
    const float seen = Visibility(mesh, Vec3(0.3f, 0.2f, -1), Vec3(0, 0, 1));
    EXPECT_TRUE(seen == 0 || seen == 1);
    const DMat4 clip = glm::perspective(1.0, 1.0, 0.1, 10.0);
    for (const auto& volume : mesh.volumes) {
      VolumeCapper(*volume, mesh.bias_px, mesh.light).CapsFor(clip, 0.1);
    }
  }
  EXPECT_GT(taken, 100);
}

}  // namespace
}  // namespace penumbra
