#include "proto/convert/params_convert.h"

#include <string>
#include <variant>

#include "proto/convert/artifact_convert.h"
#include "proto/convert/geometry_convert.h"
#include "render/scene/field_error.h"

namespace penumbra {

void Write(const SoftTextureParams& params, v1::ArtifactSpec& proto) {
  auto& parameters = *proto.mutable_soft_texture();
  parameters.set_samples(params.samples);
  parameters.set_seed(params.seed);
  parameters.set_radiance(params.radiance);
  // The protocol counts from 1 what is listed in the same order here.
  parameters.set_method(static_cast<v1::VisibilityMethod>(static_cast<int>(params.method) + 1));
  parameters.set_silhouette_reuse(params.silhouette_reuse);
  parameters.set_shading(static_cast<v1::Shading>(static_cast<int>(params.shading) + 1));
  parameters.set_form_factor_error(params.form_factor_error);
  if (params.ambient != Vec3(0.0f)) *parameters.mutable_ambient() = ToProto(params.ambient);
  parameters.set_output(ToProto(params.output));
  parameters.set_output_scale(params.output_scale);
  parameters.set_count_bits(static_cast<v1::CountBits>(static_cast<int>(params.count_bits) + 1));
}

void Write(const LayeredAttenuationParams& params, v1::ArtifactSpec& proto) {
  auto& parameters = *proto.mutable_layered_attenuation();
  parameters.set_samples(params.samples);
  parameters.set_seed(params.seed);
  parameters.set_resolution(params.resolution);
  parameters.set_tolerance(params.tolerance);
  parameters.set_source(static_cast<v1::DepthSource>(static_cast<int>(params.source) + 1));
  parameters.set_key_views(params.key_views);
  parameters.set_max_layers(params.max_layers);
}

void Write(const CoherentRaytraceParams& params, v1::ArtifactSpec& proto) {
  auto& parameters = *proto.mutable_coherent_raytrace();
  parameters.set_samples(params.samples);
  parameters.set_seed(params.seed);
  parameters.set_backend(static_cast<v1::RayBackend>(static_cast<int>(params.backend) + 1));
  parameters.set_radiance(params.radiance);
  parameters.set_output(ToProto(params.output));
  parameters.set_coherence(params.coherence);
  parameters.set_whole_light(params.whole_light);
  parameters.set_ray_accelerations(params.ray_accelerations);
  parameters.set_prediction_distance(params.prediction_distance);
  parameters.set_resolution(params.resolution);
  parameters.set_gap_bias(params.gap_bias);
  parameters.set_shadow_bias(params.shadow_bias);
}

void Write(const ShadowWidthParams& params, v1::ArtifactSpec& proto) {
  auto& parameters = *proto.mutable_shadow_width();
  parameters.set_resolution(params.resolution);
  parameters.set_distance(static_cast<v1::DistanceMethod>(static_cast<int>(params.distance) + 1));
  parameters.set_layers(params.layers);
  parameters.set_blocker_depth(
      static_cast<v1::BlockerDepth>(static_cast<int>(params.blocker_depth) + 1));
  parameters.set_c_scale(params.c_scale);
  parameters.set_c_bias(params.c_bias);
  parameters.set_source(static_cast<v1::DepthSource>(static_cast<int>(params.source) + 1));
}

void Write(const ShadowVolumeParams& params, v1::ArtifactSpec& proto) {
  auto& parameters = *proto.mutable_shadow_volume();
  parameters.set_resolution(params.resolution);
  parameters.set_bias(params.bias);
  parameters.set_low_threshold(params.low_threshold);
  parameters.set_high_threshold(params.high_threshold);
  parameters.set_surface(static_cast<v1::VolumeSurface>(static_cast<int>(params.surface) + 1));
  parameters.set_volumes_of(static_cast<v1::VolumesOf>(static_cast<int>(params.volumes_of) + 1));
  parameters.set_object_ids(params.object_ids);
  parameters.set_source(static_cast<v1::DepthSource>(static_cast<int>(params.source) + 1));
}

namespace {

// The value that `number` stands for, which the protocol counts from 1; `value` stays as it is for
// 0. Errors  RANGE: none of `count`
template <typename Enum>
absl::Status ReadEnum(int number, size_t count, const char* field, Enum& value) {
  if (number < 0 || number > static_cast<int>(count)) {
    return FieldError(absl::StatusCode::kInvalidArgument, "RANGE", field,
                      "found " + std::to_string(number) + ", need one that this server knows");
  }
  if (number > 0) value = static_cast<Enum>(number - 1);
  return absl::OkStatus();
}

absl::Status ReadShading(const v1::SoftTextureParameters& proto, SoftTextureParams& params) {
  if (proto.has_form_factor_error()) params.form_factor_error = proto.form_factor_error();
  if (proto.has_ambient()) params.ambient = FromProto(proto.ambient());
  params.output_scale = proto.output_scale();
  absl::Status status =
      ReadEnum(proto.shading(), kShadingNames.size(), "spec.soft_texture.shading", params.shading);
  status.Update(ReadEnum(proto.output(), kRadianceFormatNames.size(), "spec.soft_texture.output",
                         params.output));
  status.Update(ReadEnum(proto.count_bits(), kCountBitsNames.size(), "spec.soft_texture.count_bits",
                         params.count_bits));
  return status;
}

absl::StatusOr<TechniqueParams> Read(const v1::SoftTextureParameters& proto) {
  SoftTextureParams params;
  if (proto.has_samples()) params.samples = proto.samples();
  if (proto.has_seed()) params.seed = proto.seed();
  if (proto.has_radiance()) params.radiance = proto.radiance();
  if (!v1::VisibilityMethod_IsValid(proto.method())) {
    return FieldError(
        absl::StatusCode::kInvalidArgument, "RANGE", "spec.soft_texture.method",
        "found " + std::to_string(proto.method()) + ", need a method that this server knows");
  }
  if (proto.method() != v1::VISIBILITY_METHOD_UNSPECIFIED) {
    params.method = static_cast<VisibilityMethod>(proto.method() - 1);
  }
  if (proto.silhouette_reuse() != 0) params.silhouette_reuse = proto.silhouette_reuse();
  if (auto status = ReadShading(proto, params); !status.ok()) return status;
  return params;
}

absl::StatusOr<TechniqueParams> Read(const v1::LayeredAttenuationParameters& proto) {
  LayeredAttenuationParams params;
  if (proto.has_samples()) params.samples = proto.samples();
  if (proto.has_seed()) params.seed = proto.seed();
  if (proto.has_resolution()) params.resolution = proto.resolution();
  params.tolerance = proto.tolerance();
  params.key_views = proto.key_views();
  if (proto.has_max_layers()) params.max_layers = proto.max_layers();
  const absl::Status status = ReadEnum(proto.source(), kDepthMethodNames.size(),
                                       "spec.layered_attenuation.source", params.source);
  if (!status.ok()) return status;
  return params;
}

absl::StatusOr<TechniqueParams> Read(const v1::CoherentRaytraceParameters& proto) {
  CoherentRaytraceParams params;
  if (proto.has_samples()) params.samples = proto.samples();
  if (proto.has_seed()) params.seed = proto.seed();
  if (proto.has_radiance()) params.radiance = proto.radiance();
  if (proto.has_coherence()) params.coherence = proto.coherence();
  if (proto.has_whole_light()) params.whole_light = proto.whole_light();
  if (proto.has_ray_accelerations()) params.ray_accelerations = proto.ray_accelerations();
  params.prediction_distance = proto.prediction_distance();
  if (proto.has_resolution()) params.resolution = proto.resolution();
  params.gap_bias = proto.gap_bias();
  params.shadow_bias = proto.shadow_bias();
  absl::Status status = ReadEnum(proto.backend(), kRayBackendNames.size(),
                                 "spec.coherent_raytrace.backend", params.backend);
  status.Update(ReadEnum(proto.output(), kRadianceFormatNames.size(),
                         "spec.coherent_raytrace.output", params.output));
  if (!status.ok()) return status;
  return params;
}

absl::StatusOr<TechniqueParams> Read(const v1::ShadowWidthParameters& proto) {
  ShadowWidthParams params;
  if (proto.has_resolution()) params.resolution = proto.resolution();
  if (proto.has_layers()) params.layers = proto.layers();
  params.c_scale = proto.c_scale();
  params.c_bias = proto.c_bias();
  absl::Status status = ReadEnum(proto.distance(), kDistanceMethodNames.size(),
                                 "spec.shadow_width.distance", params.distance);
  status.Update(ReadEnum(proto.blocker_depth(), kBlockerDepthNames.size(),
                         "spec.shadow_width.blocker_depth", params.blocker_depth));
  status.Update(ReadEnum(proto.source(), kDepthMethodNames.size(), "spec.shadow_width.source",
                         params.source));
  if (!status.ok()) return status;
  return params;
}

absl::StatusOr<TechniqueParams> Read(const v1::ShadowVolumeParameters& proto) {
  ShadowVolumeParams params;
  if (proto.has_resolution()) params.resolution = proto.resolution();
  if (proto.has_bias()) params.bias = proto.bias();
  params.low_threshold = proto.low_threshold();
  params.high_threshold = proto.high_threshold();
  params.object_ids = proto.object_ids();
  absl::Status status = ReadEnum(proto.surface(), kVolumeSurfaceNames.size(),
                                 "spec.shadow_volume.surface", params.surface);
  status.Update(ReadEnum(proto.volumes_of(), kVolumesOfNames.size(),
                         "spec.shadow_volume.volumes_of", params.volumes_of));
  status.Update(ReadEnum(proto.source(), kDepthMethodNames.size(), "spec.shadow_volume.source",
                         params.source));
  if (!status.ok()) return status;
  return params;
}

}  // namespace

absl::StatusOr<TechniqueParams> ReadParams(const v1::ArtifactSpec& proto) {
  // Every technique of the list needs a case below; the count makes a new one fail here.
  static_assert(std::variant_size_v<TechniqueParams> == 5);
  switch (proto.technique_case()) {
    case v1::ArtifactSpec::kSoftTexture:
      return Read(proto.soft_texture());
    case v1::ArtifactSpec::kLayeredAttenuation:
      return Read(proto.layered_attenuation());
    case v1::ArtifactSpec::kCoherentRaytrace:
      return Read(proto.coherent_raytrace());
    case v1::ArtifactSpec::kShadowWidth:
      return Read(proto.shadow_width());
    case v1::ArtifactSpec::kShadowVolume:
      return Read(proto.shadow_volume());
    case v1::ArtifactSpec::TECHNIQUE_NOT_SET:
      break;
  }
  std::string known;
  for (const auto& params : AllTechniques()) {
    known += (known.empty() ? "" : ", ") + std::string(InfoOf(params).name);
  }
  return FieldError(absl::StatusCode::kInvalidArgument, "UNKNOWN_TECHNIQUE", "spec.technique",
                    "found none that this server knows, need one of: " + known);
}

}  // namespace penumbra
