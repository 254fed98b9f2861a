#include "proto/convert/spec_convert.h"

#include <string>
#include <utility>
#include <variant>

#include "proto/convert/artifact_convert.h"
#include "proto/convert/geometry_convert.h"
#include "render/scene/field_error.h"
#include "render/scene/scene.h"

namespace penumbra {
namespace {

// One overload of Write a technique: a new one does not compile without.
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

absl::StatusOr<TechniqueParams> ReadTechnique(const v1::ArtifactSpec& proto) {
  // Every technique of the list needs a case below; the count makes a new one fail here.
  static_assert(std::variant_size_v<TechniqueParams> == 1);
  switch (proto.technique_case()) {
    case v1::ArtifactSpec::kSoftTexture:
      return Read(proto.soft_texture());
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

}  // namespace

v1::ArtifactSpec ToProto(const ArtifactSpec& spec) {
  v1::ArtifactSpec proto;
  proto.set_light_id(spec.light_id);
  proto.set_receiver_id(spec.receiver_id);
  proto.set_time_budget_ms(spec.time_budget_ms);
  std::visit([&](const auto& params) { Write(params, proto); }, spec.params);
  return proto;
}

absl::StatusOr<ArtifactSpec> FromProto(const v1::ArtifactSpec& proto) {
  auto params = ReadTechnique(proto);
  if (!params.ok()) return params.status();
  if (proto.light_id() != kAllLights) {
    if (auto status = CheckId(proto.light_id(), "spec.light_id"); !status.ok()) return status;
  }
  if (auto status = CheckId(proto.receiver_id(), "spec.receiver_id"); !status.ok()) return status;
  ArtifactSpec spec{.params = *std::move(params),
                    .light_id = proto.light_id(),
                    .receiver_id = proto.receiver_id(),
                    .time_budget_ms = proto.time_budget_ms()};
  if (auto status = CheckTimeBudget(spec); !status.ok()) return WithFieldPrefix(status, "spec.");
  return spec;
}

v1::TechniqueInfo ToProto(const TechniqueInfo& info) {
  v1::TechniqueInfo proto;
  proto.set_name(std::string(info.name));
  proto.set_summary(std::string(info.summary));
  proto.set_artifact_kind(std::string(info.artifact_kind));
  proto.set_source(std::string(info.source));
  for (const auto& parameter : info.parameters) {
    auto& described = *proto.add_parameters();
    described.set_name(std::string(parameter.name));
    described.set_type(std::string(parameter.type));
    described.set_default_value(std::string(parameter.default_value));
    described.set_range(std::string(parameter.range));
    described.set_meaning(std::string(parameter.meaning));
  }
  return proto;
}

std::vector<v1::TechniqueInfo> AllTechniqueInfos() {
  std::vector<v1::TechniqueInfo> all;
  for (const auto& params : AllTechniques()) all.push_back(ToProto(InfoOf(params)));
  return all;
}

}  // namespace penumbra
