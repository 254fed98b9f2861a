#include <nlohmann/json.hpp>

#include "client/cli/bake_files.h"
#include "client/cli/light_json.h"

namespace penumbra {
namespace {

using Json = nlohmann::ordered_json;

Json ToJson(Vec3 v) { return {v.x, v.y, v.z}; }

// A number or a truth value where the text is one.
Json ParameterToJson(const std::string& text) {
  Json value = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  return value.is_number() || value.is_boolean() ? value : Json(text);
}

Json ToJson(const std::map<std::string, std::string>& parameters) {
  Json json = Json::object();
  for (const auto& [name, text] : parameters) json[name] = ParameterToJson(text);
  return json;
}

Json ToJson(const LightSample& sample) {
  return {{sample.at_infinity ? "direction" : "position", ToJson(sample.point)},
          {"weight", sample.weight}};
}

Json ReceiverToJson(const std::string& id, const ReceiverPatch& receiver) {
  return {{"id", id},
          {"origin", ToJson(receiver.patch.origin)},
          {"edge_u", ToJson(receiver.patch.edge_u)},
          {"edge_v", ToJson(receiver.patch.edge_v)},
          {"width", receiver.width},
          {"height", receiver.height},
          {"two_sided", receiver.two_sided},
          {"reflectance", ToJson(receiver.reflectance)}};
}

}  // namespace

std::string BakeJson(const BakeRecord& record, const SoftShadowTexture& texture, float exposure) {
  const ArtifactHeader& header = record.artifact.header;
  Json samples = Json::array();
  for (const LightSample& sample : header.light_samples) samples.push_back(ToJson(sample));
  Json timings = Json::object();
  for (const auto& [stage, ms] : header.timings_ms) timings[stage] = ms;
  timings["wall"] = record.wall_ms;

  const Json json = {
      {"technique", header.technique},
      {"parameters", ToJson(header.parameters)},
      {"scene", record.scene},
      {"scene_hash", header.scene_hash.hex()},
      {"revision", header.revision},
      {"receiver", ReceiverToJson(header.receiver_id, texture.receiver)},
      {"light", LightToJson(texture.light)},
      {"inside_texels",
       texture.coverage ? texture.coverage->CountInside() : texture.visibility.counts.size()},
      {"sample_count", texture.visibility.sample_count},
      {"error_estimate", header.error_estimate},
      {"light_samples", std::move(samples)},
      {"timings_ms", std::move(timings)},
      {"files", {{"exr", record.name + ".exr"}, {"png", record.name + ".png"}}},
      {"png", {{"transfer", "sRGB"}, {"tone", "clipped at 1"}, {"exposure", exposure}}}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace penumbra
