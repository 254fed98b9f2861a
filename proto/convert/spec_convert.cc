#include "proto/convert/spec_convert.h"

#include <string>
#include <utility>
#include <variant>

#include "proto/convert/params_convert.h"
#include "proto/convert/points_convert.h"
#include "render/scene/field_error.h"
#include "render/scene/scene.h"

namespace penumbra {

v1::ArtifactSpec ToProto(const ArtifactSpec& spec) {
  v1::ArtifactSpec proto;
  proto.set_light_id(spec.light_id);
  proto.set_receiver_id(spec.receiver_id);
  proto.set_time_budget_ms(spec.time_budget_ms);
  if (spec.points) *proto.mutable_points() = ToProto(*spec.points);
  std::visit([&](const auto& params) { Write(params, proto); }, spec.params);
  return proto;
}

absl::StatusOr<ArtifactSpec> FromProto(const v1::ArtifactSpec& proto) {
  auto params = ReadParams(proto);
  if (!params.ok()) return params.status();
  if (proto.light_id() != kAllLights) {
    if (auto status = CheckId(proto.light_id(), "spec.light_id"); !status.ok()) return status;
  }
  ArtifactSpec spec{.params = *std::move(params),
                    .light_id = proto.light_id(),
                    .receiver_id = proto.receiver_id(),
                    .time_budget_ms = proto.time_budget_ms()};
  if (proto.has_points()) {
    auto points = FromProto(proto.points());
    if (!points.ok()) return WithFieldPrefix(points.status(), "spec.points.");
    spec.points = *std::move(points);
  }
  if (auto status = CheckTarget(spec); !status.ok()) return WithFieldPrefix(status, "spec.");
  if (auto status = CheckTimeBudget(spec); !status.ok()) return WithFieldPrefix(status, "spec.");
  return spec;
}

absl::StatusOr<SpecTarget> TargetOf(const v1::ArtifactSpec& proto) {
  const auto params = ReadParams(proto);
  if (!params.ok()) return params.status();
  return InfoOf(*params).target;
}

v1::TechniqueInfo ToProto(const TechniqueInfo& info) {
  v1::TechniqueInfo proto;
  proto.set_name(std::string(info.name));
  proto.set_summary(std::string(info.summary));
  proto.set_artifact_kind(std::string(info.artifact_kind));
  proto.set_source(std::string(info.source));
  // The protocol counts from 1 what is listed in the same order here.
  proto.set_target(static_cast<v1::SpecTarget>(static_cast<int>(info.target) + 1));
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
