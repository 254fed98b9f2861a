#include "proto/convert/artifact_convert.h"

#include <bit>
#include <cstring>
#include <utility>
#include <variant>

#include "proto/convert/geometry_convert.h"
#include "proto/convert/ldi_convert.h"
#include "proto/convert/light_convert.h"
#include "proto/convert/points_convert.h"
#include "proto/convert/volume_convert.h"
#include "proto/convert/width_convert.h"
#include "render/scene/field_error.h"
#include "render/scene/scene_check.h"

namespace penumbra {
namespace {

static_assert(std::endian::native == std::endian::little, "light samples are copied as they lie");

struct PackedLightSample {
  float x, y, z, weight;
  uint32_t flags;
};
static_assert(sizeof(PackedLightSample) == 20);
constexpr uint32_t kAtInfinityFlag = 1;

v1::ReceiverPatch ToProto(const ReceiverPatch& receiver) {
  v1::ReceiverPatch proto;
  *proto.mutable_patch() = penumbra::ToProto(receiver.patch);
  proto.set_width(receiver.width);
  proto.set_height(receiver.height);
  proto.set_two_sided(receiver.two_sided);
  *proto.mutable_reflectance() = penumbra::ToProto(receiver.reflectance);
  return proto;
}

ReceiverPatch Read(const v1::ReceiverPatch& proto) {
  return {.patch = FromProto(proto.patch()),
          .width = proto.width(),
          .height = proto.height(),
          .two_sided = proto.two_sided(),
          .reflectance = FromProto(proto.reflectance())};
}

// What is said of the texels, by kinds of artifacts that have some.
template <typename Proto>
void WriteTexels(const ShadowTexels& texels, Proto& proto) {
  proto.set_sample_count(texels.visibility.sample_count);
  proto.set_has_radiance(texels.radiance.has_value());
  if (!texels.radiance) return;
  proto.set_radiance_format(penumbra::ToProto(texels.radiance->format));
  proto.set_radiance_scale(texels.radiance->scale);
}

// One overload of Write a kind of artifact: a new one does not compile without.
void Write(const SoftShadowTexture& texture, v1::ArtifactHeader& proto) {
  auto& kind = *proto.mutable_soft_shadow_texture();
  *kind.mutable_receiver() = ToProto(texture.receiver);
  *kind.mutable_light() = penumbra::ToProto(texture.light);
  WriteTexels(texture, kind);
  kind.set_has_coverage(texture.coverage != nullptr);
  kind.set_count_bits(texture.count_bits);
}

void Write(const AttenuationLdi& ldi, v1::ArtifactHeader& proto) {
  *proto.mutable_attenuation_ldi() = penumbra::ToProto(ldi);
}

void Write(const ShadowWidthMap& map, v1::ArtifactHeader& proto) {
  *proto.mutable_shadow_width_map() = penumbra::ToProto(map);
}

void Write(const ShadowVolumeMesh& mesh, v1::ArtifactHeader& proto) {
  *proto.mutable_shadow_volume_mesh() = penumbra::ToProto(mesh);
}

void Write(const ViewShadow& shadow, v1::ArtifactHeader& proto) {
  auto& kind = *proto.mutable_view_shadow();
  *kind.mutable_points() = penumbra::ToProto(shadow.points);
  kind.set_width(shadow.visibility.width);
  kind.set_height(shadow.visibility.height);
  *kind.mutable_light() = penumbra::ToProto(shadow.light);
  WriteTexels(shadow, kind);
  auto& progress = *kind.mutable_progress();
  progress.set_fraction_done(shadow.progress.fraction_done);
  progress.set_rays_traced(shadow.progress.rays_traced);
  progress.set_time_left_ms(shadow.progress.time_left_ms);
}

absl::Status CheckGrid(uint64_t width, uint64_t height, const std::string& field,
                       const SceneLimits& limits) {
  if (width > 0 && height > 0 && width <= limits.max_receiver_side &&
      height <= limits.max_receiver_side && width * height <= limits.max_receiver_texels) {
    return absl::OkStatus();
  }
  return FieldError(absl::StatusCode::kInvalidArgument, "RANGE", field,
                    "found " + std::to_string(width) + " by " + std::to_string(height) +
                        " texels, need sides of 1 to " + std::to_string(limits.max_receiver_side) +
                        " and at most " + std::to_string(limits.max_receiver_texels) + " texels");
}

absl::Status RangeError(const std::string& field, const std::string& found, const char* need) {
  return FieldError(absl::StatusCode::kInvalidArgument, "RANGE", field,
                    "found " + found + ", need " + need);
}

template <typename Proto>
absl::Status CheckTexels(const Proto& proto, const std::string& kind) {
  if (proto.sample_count() > UINT16_MAX) {
    return RangeError(kind + ".sample_count", std::to_string(proto.sample_count()),
                      "at most 65535");
  }
  if (!v1::RadianceFormat_IsValid(proto.radiance_format())) {
    return RangeError(kind + ".radiance_format", std::to_string(proto.radiance_format()),
                      "one that this program knows");
  }
  const bool has_scale = proto.radiance_format() == v1::RADIANCE_FORMAT_UNORM16 ||
                         proto.radiance_format() == v1::RADIANCE_FORMAT_UNORM8;
  if (has_scale && !(proto.radiance_scale() > 0 && IsFinite(proto.radiance_scale()))) {
    return RangeError(kind + ".radiance_scale", std::to_string(proto.radiance_scale()),
                      "a finite number above 0");
  }
  return absl::OkStatus();
}

absl::Status CheckCountBits(const v1::SoftShadowTexture& proto) {
  const uint32_t bits = proto.count_bits();
  if (bits == 0 || bits == 16 || (bits == 8 && proto.sample_count() <= UINT8_MAX)) {
    return absl::OkStatus();
  }
  return RangeError("soft_shadow_texture.count_bits", std::to_string(bits),
                    "0, 16, or 8 for at most 255 samples");
}

// All counts 0, all radiance black.
template <typename Proto>
void ReadTexels(const Proto& proto, uint32_t width, uint32_t height, ShadowTexels& texels) {
  texels.visibility = {.width = width,
                       .height = height,
                       .sample_count = proto.sample_count(),
                       .counts = std::vector<uint16_t>(size_t{width} * height)};
  if (!proto.has_radiance()) return;
  texels.radiance = RadianceTexture{
      .width = width, .height = height, .texels = std::vector<Vec3>(size_t{width} * height)};
  if (proto.radiance_format() != v1::RADIANCE_FORMAT_UNSPECIFIED) {
    texels.radiance->format = static_cast<RadianceFormat>(proto.radiance_format() - 1);
  }
  if (IsUnorm(texels.radiance->format)) texels.radiance->scale = proto.radiance_scale();
}

absl::StatusOr<SoftShadowTexture> Read(const v1::SoftShadowTexture& proto,
                                       const SceneLimits& limits) {
  const uint32_t width = proto.receiver().width(), height = proto.receiver().height();
  absl::Status status = CheckGrid(width, height, "soft_shadow_texture.receiver", limits);
  if (status.ok()) status = CheckTexels(proto, "soft_shadow_texture");
  if (status.ok()) status = CheckCountBits(proto);
  if (!status.ok()) return status;
  auto light = FromProto(proto.light(), "soft_shadow_texture.light");
  if (!light.ok()) return light.status();
  SoftShadowTexture texture;
  texture.receiver = Read(proto.receiver());
  status = CheckPatch(texture.receiver.patch, "soft_shadow_texture.receiver.patch");
  if (!status.ok()) return status;
  texture.light = *std::move(light);
  ReadTexels(proto, width, height, texture);
  if (proto.has_coverage()) texture.coverage = std::make_shared<CoverageMask>(width, height);
  texture.count_bits = proto.count_bits();
  return texture;
}

absl::StatusOr<ViewShadow> Read(const v1::ViewShadow& proto, const SceneLimits& limits) {
  absl::Status status = CheckGrid(proto.width(), proto.height(), "view_shadow", limits);
  if (status.ok()) status = CheckTexels(proto, "view_shadow");
  if (!status.ok()) return status;
  auto light = FromProto(proto.light(), "view_shadow.light");
  if (!light.ok()) return light.status();
  auto points = FromProto(proto.points());
  if (!points.ok()) return WithFieldPrefix(points.status(), "view_shadow.points.");
  ViewShadow shadow;
  shadow.points = *std::move(points);
  shadow.light = *std::move(light);
  shadow.progress = {.fraction_done = proto.progress().fraction_done(),
                     .rays_traced = proto.progress().rays_traced(),
                     .time_left_ms = proto.progress().time_left_ms()};
  ReadTexels(proto, proto.width(), proto.height(), shadow);
  shadow.coverage = std::make_shared<CoverageMask>(proto.width(), proto.height());
  return shadow;
}

// The payload, or the error in place of it.
template <typename Kind>
absl::StatusOr<ArtifactPayload> PayloadOf(absl::StatusOr<Kind> kind) {
  if (!kind.ok()) return kind.status();
  return ArtifactPayload(*std::move(kind));
}

absl::StatusOr<ArtifactPayload> ReadPayload(const v1::ArtifactHeader& proto,
                                            const SceneLimits& limits) {
  switch (proto.kind_case()) {
    case v1::ArtifactHeader::kSoftShadowTexture:
      return PayloadOf(Read(proto.soft_shadow_texture(), limits));
    case v1::ArtifactHeader::kAttenuationLdi:
      return PayloadOf(FromProto(proto.attenuation_ldi(), limits));
    case v1::ArtifactHeader::kViewShadow:
      return PayloadOf(Read(proto.view_shadow(), limits));
    case v1::ArtifactHeader::kShadowWidthMap:
      return PayloadOf(FromProto(proto.shadow_width_map(), limits));
    case v1::ArtifactHeader::kShadowVolumeMesh:
      return PayloadOf(FromProto(proto.shadow_volume_mesh()));
    case v1::ArtifactHeader::KIND_NOT_SET:
      break;
  }
  return FieldError(absl::StatusCode::kInvalidArgument, "MISSING_FIELD", "header.kind",
                    "found none that this program knows, need a kind of artifact");
}

}  // namespace

// The protocol counts from 1 what is listed in the same order here.
v1::RadianceFormat ToProto(RadianceFormat format) {
  return static_cast<v1::RadianceFormat>(static_cast<int>(format) + 1);
}

v1::ArtifactHeader ToProto(const Artifact& artifact) {
  const ArtifactHeader& header = artifact.header;
  v1::ArtifactHeader proto;
  proto.set_scene_id(header.scene_id);
  proto.set_computed_revision(header.revision);
  proto.set_scene_hash(ToProto(header.scene_hash));
  proto.set_technique(header.technique);
  proto.set_light_id(header.light_id);
  proto.set_receiver_id(header.receiver_id);
  proto.mutable_parameters()->insert(header.parameters.begin(), header.parameters.end());
  proto.set_samples_requested(header.samples_requested);
  proto.set_pass(header.pass);
  proto.set_is_final(header.is_final);
  proto.set_error_estimate(header.error_estimate);
  proto.mutable_timings_ms()->insert(header.timings_ms.begin(), header.timings_ms.end());
  std::visit([&](const auto& payload) { Write(payload, proto); }, artifact.payload);
  return proto;
}

absl::StatusOr<Artifact> FromProto(const v1::ArtifactHeader& proto, const SceneLimits& limits) {
  const auto hash = HashFromProto(proto.scene_hash(), "header.scene_hash");
  if (!hash.ok()) return hash.status();
  auto payload = ReadPayload(proto, limits);
  if (!payload.ok()) return payload.status();
  return Artifact{.header = {.scene_id = proto.scene_id(),
                             .revision = proto.computed_revision(),
                             .scene_hash = *hash,
                             .technique = proto.technique(),
                             .light_id = proto.light_id(),
                             .receiver_id = proto.receiver_id(),
                             .parameters = {proto.parameters().begin(), proto.parameters().end()},
                             .light_samples = {},
                             .samples_requested = proto.samples_requested(),
                             .pass = proto.pass(),
                             .is_final = proto.is_final(),
                             .error_estimate = proto.error_estimate(),
                             .timings_ms = {proto.timings_ms().begin(), proto.timings_ms().end()}},
                  .payload = *std::move(payload)};
}

std::string EncodeLightSamples(std::span<const LightSample> samples) {
  std::string bytes(samples.size() * sizeof(PackedLightSample), '\0');
  for (size_t i = 0; i < samples.size(); ++i) {
    const LightSample& sample = samples[i];
    const PackedLightSample packed{sample.point.x, sample.point.y, sample.point.z, sample.weight,
                                   sample.at_infinity ? kAtInfinityFlag : 0};
    std::memcpy(&bytes[i * sizeof(packed)], &packed, sizeof(packed));
  }
  return bytes;
}

absl::StatusOr<std::vector<LightSample>> DecodeLightSamples(const std::string& bytes) {
  if (bytes.size() % sizeof(PackedLightSample) != 0) {
    return FieldError(absl::StatusCode::kInvalidArgument, "LENGTH", "light_samples",
                      "found " + std::to_string(bytes.size()) + " bytes, need a multiple of 20");
  }
  std::vector<LightSample> samples(bytes.size() / sizeof(PackedLightSample));
  for (size_t i = 0; i < samples.size(); ++i) {
    PackedLightSample packed;
    std::memcpy(&packed, &bytes[i * sizeof(packed)], sizeof(packed));
    samples[i] = {.point = {packed.x, packed.y, packed.z},
                  .at_infinity = (packed.flags & kAtInfinityFlag) != 0,
                  .weight = packed.weight};
  }
  return samples;
}

}  // namespace penumbra
