#include "proto/convert/spec_convert.h"

#include <string>
#include <variant>

#include "render/scene/field_error.h"

namespace penumbra {
namespace {

// One overload of Write a technique: a new one does not compile without.
void Write(const SoftTextureParams& params, v1::ArtifactSpec& proto) {
  auto& parameters = *proto.mutable_soft_texture();
  parameters.set_samples(params.samples);
  parameters.set_seed(params.seed);
  parameters.set_radiance(params.radiance);
}

SoftTextureParams Read(const v1::SoftTextureParameters& proto) {
  SoftTextureParams params;
  if (proto.has_samples()) params.samples = proto.samples();
  if (proto.has_seed()) params.seed = proto.seed();
  if (proto.has_radiance()) params.radiance = proto.radiance();
  return params;
}

}  // namespace

v1::ArtifactSpec ToProto(const ArtifactSpec& spec) {
  v1::ArtifactSpec proto;
  proto.set_light_id(spec.light_id);
  proto.set_receiver_id(spec.receiver_id);
  std::visit([&](const auto& params) { Write(params, proto); }, spec.params);
  return proto;
}

absl::StatusOr<ArtifactSpec> FromProto(const v1::ArtifactSpec& proto) {
  // Every technique of the list needs a case below; the count makes a new one fail here.
  static_assert(std::variant_size_v<TechniqueParams> == 1);
  ArtifactSpec spec{.params = {}, .light_id = proto.light_id(), .receiver_id = proto.receiver_id()};
  switch (proto.technique_case()) {
    case v1::ArtifactSpec::kSoftTexture:
      spec.params = Read(proto.soft_texture());
      return spec;
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
