#include "tests/fuzz/targets/whole_artifact.h"

#include <zstd.h>

#include <algorithm>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "google/protobuf/descriptor.h"
#include "proto/convert/artifact_assembler.h"
#include "proto/convert/artifact_convert.h"
#include "proto/convert/coverage_codec.h"
#include "proto/convert/ldi_codec.h"
#include "proto/convert/tile_codec.h"
#include "proto/convert/volume_codec.h"
#include "proto/convert/width_codec.h"
#include "tests/fuzz/kit/require.h"
#include "tests/fuzz/targets/artifact_bytes.h"
#include "tests/fuzz/targets/artifact_rules.h"

namespace penumbra::fuzzing {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

void AddTexels(const ShadowTexels& texels, v1::ArtifactUpdate& update) {
  const TileGrid grid = GridOf(texels);
  TileEncoder encoder;
  for (uint32_t row = 0; row < grid.rows(); ++row) {
    for (uint32_t column = 0; column < grid.columns(); ++column) {
      *update.add_tiles() = encoder.Encode(texels, column, row);
    }
  }
  if (!texels.coverage) return;
  for (uint32_t i = 0; i < CoveragePartCount(*texels.coverage); ++i) {
    *update.add_coverage() = EncodePart(*texels.coverage, i);
  }
}

void AddVolumes(const ShadowVolumeMesh& mesh, v1::ArtifactUpdate& update) {
  VolumePartEncoder encoder;
  std::vector<std::string> heads;
  std::vector<v1::VolumePart> parts;
  for (const auto& volume : mesh.volumes) {
    const auto plans = PartsOf(*volume);
    heads.push_back(plans.front().name);
    for (const VolumePartPlan& plan : plans) parts.push_back(encoder.Encode(*volume, plan));
  }
  std::vector<VolumePartPlan> lists;
  for (const std::string& name : ListNames(heads, lists)) {
    update.mutable_header()->mutable_shadow_volume_mesh()->add_volumes(name);
  }
  for (const VolumePartPlan& list : lists) *update.add_volume_parts() = EncodeList(list);
  for (v1::VolumePart& part : parts) *update.add_volume_parts() = std::move(part);
}

void AddPayload(const ArtifactPayload& payload, v1::ArtifactUpdate& update) {
  if (const ShadowTexels* texels = TexelsOf(payload)) {
    AddTexels(*texels, update);
  } else if (const auto* ldi = std::get_if<AttenuationLdi>(&payload)) {
    LdiTileEncoder encoder;
    for (const auto& place : LdiTilesOf(*ldi))
      *update.add_ldi_tiles() = encoder.Encode(*ldi, place);
  } else if (const auto* map = std::get_if<ShadowWidthMap>(&payload)) {
    WidthTileEncoder encoder;
    for (const auto& place : WidthTilesOf(*map)) {
      *update.add_width_tiles() = encoder.Encode(*map, place);
    }
  } else {
    AddVolumes(std::get<ShadowVolumeMesh>(payload), update);
  }
}

std::string Unpacked(const std::string& packed) {
  std::string plane(ZSTD_getFrameContentSize(packed.data(), packed.size()), '\0');
  ZSTD_decompress(plane.data(), plane.size(), packed.data(), packed.size());
  return plane;
}

// A codec is followed by what it packs, in all messages that have one.
void UnpackPlanes(Message& message) {
  const auto& type = *message.GetDescriptor();
  const auto& reflection = *message.GetReflection();
  for (int i = 0; i < type.field_count(); ++i) {
    const FieldDescriptor* field = type.field(i);
    if (field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE && !field->is_map()) {
      const bool is_list = field->is_repeated();
      const int count = is_list ? reflection.FieldSize(message, field)
                                : static_cast<int>(reflection.HasField(message, field));
      for (int k = 0; k < count; ++k) {
        UnpackPlanes(is_list ? *reflection.MutableRepeatedMessage(&message, field, k)
                             : *reflection.MutableMessage(&message, field));
      }
    }
    if (field->enum_type() != v1::Codec_descriptor() || field->is_repeated()) continue;
    if (reflection.GetEnumValue(message, field) != v1::CODEC_ZSTD) continue;
    const FieldDescriptor* packed = type.field(i + 1);
    reflection.SetString(&message, packed, Unpacked(reflection.GetString(message, packed)));
    reflection.SetEnumValue(&message, field, v1::CODEC_RAW);
  }
}

// Whether it has a volume twice, which a server that sends its own has no way to tell apart.
bool HasTwins(const ArtifactPayload& payload) {
  const auto* mesh = std::get_if<ShadowVolumeMesh>(&payload);
  if (!mesh) return false;
  std::set<std::string> names;
  for (const auto& volume : mesh->volumes) {
    if (!names.insert(PartsOf(*volume).front().name).second) return true;
  }
  return false;
}

// Whether its codes are of radiance that there can be. Others are read as they come, and would be
// sent as the nearest that there can be.
bool HasPlainRadiance(const ArtifactPayload& payload) {
  constexpr float kLeastScale = 1e-3f, kMostScale = 1e3f;
  const ShadowTexels* texels = TexelsOf(payload);
  if (!texels || !texels->radiance) return true;
  const RadianceTexture& radiance = *texels->radiance;
  if (!(radiance.scale >= kLeastScale && radiance.scale <= kMostScale)) return false;
  return std::ranges::all_of(radiance.texels, [](const Vec3& rgb) {
    for (int c = 0; c < 3; ++c) {
      if (!(rgb[c] >= 0 && rgb[c] <= kLargestHalf)) return false;
    }
    return true;
  });
}

}  // namespace

v1::ArtifactUpdate WholeUpdate(const Artifact& artifact, uint64_t sequence) {
  v1::ArtifactUpdate update;
  update.set_subscription_id(1);
  update.set_update_sequence(sequence);
  update.set_revision(artifact.header.revision);
  *update.mutable_header() = ToProto(artifact);
  update.set_light_samples(EncodeLightSamples(artifact.header.light_samples));
  AddPayload(artifact.payload, update);
  update.set_end_of_update(true);
  return update;
}

v1::ArtifactUpdate WithRawPlanes(v1::ArtifactUpdate update) {
  UnpackPlanes(update);
  return update;
}

void RequireSound(const std::shared_ptr<const Artifact>& artifact, const SceneLimits& limits) {
  Require(artifact != nullptr, "an update without an error has an artifact");
  RequireRules(*artifact, limits);
  RequireLookups(*artifact);
  if (HasTwins(artifact->payload)) return;
  ArtifactAssembler assembler(limits);
  const auto update = assembler.Add(WholeUpdate(*artifact, 1));
  Require(update.ok(), "an artifact can be sent on: " + update.status().ToString());
  Require(update->has_value() && (*update)->artifact, "an update that is whole is an artifact");
  Require(!HasPlainRadiance(artifact->payload) ||
              BytesOfArtifact(*(*update)->artifact) == BytesOfArtifact(*artifact),
          "an artifact is the same after the way over the wire");
}

}  // namespace penumbra::fuzzing
