// penumbra techniques, penumbra info.
#include <nlohmann/json.hpp>
#include <string>

#include "absl/strings/str_cat.h"
#include "client/cli/open_engine.h"
#include "client/cli/run_command.h"
#include "client/cli/server_json.h"
#include "client/cli/status_table.h"
#include "client/cli/version.h"
#include "client/session/remote_engine.h"
#include "render/scene/scene_limits.h"

namespace penumbra {
namespace {

using Json = nlohmann::ordered_json;

// As the protocol calls it.
const char* TargetName(SpecTarget target) {
  switch (target) {
    case SpecTarget::kReceiver:
      return "SPEC_TARGET_RECEIVER";
    case SpecTarget::kScene:
      return "SPEC_TARGET_SCENE";
    case SpecTarget::kPoints:
      return "SPEC_TARGET_POINTS";
  }
  return "";
}

// The same shape as ListTechniquesResponse has in JSON.
Json LocalTechniques() {
  Json techniques = Json::array();
  for (const TechniqueParams& params : AllTechniques()) {
    const TechniqueInfo& info = InfoOf(params);
    Json parameters = Json::array();
    for (const ParameterInfo& parameter : info.parameters) {
      parameters.push_back({{"name", parameter.name},
                            {"type", parameter.type},
                            {"default_value", parameter.default_value},
                            {"range", parameter.range},
                            {"meaning", parameter.meaning}});
    }
    techniques.push_back({{"name", info.name},
                          {"summary", info.summary},
                          {"artifact_kind", info.artifact_kind},
                          {"source", info.source},
                          {"target", TargetName(info.target)},
                          {"parameters", std::move(parameters)}});
  }
  return {{"techniques", std::move(techniques)}};
}

Json LocalInfo() {
  const SceneLimits limits;
  return {{"client", VersionText()},
          {"limits",
           {{"max_vertices_per_mesh", limits.max_vertices_per_mesh},
            {"max_triangles_per_mesh", limits.max_triangles_per_mesh},
            {"max_instances", limits.max_instances},
            {"max_lights", limits.max_lights},
            {"max_receivers", limits.max_receivers},
            {"max_triangles_per_scene", limits.max_triangles_per_scene},
            {"max_receiver_side", limits.max_receiver_side},
            {"max_receiver_texels", limits.max_receiver_texels},
            {"max_light_samples", limits.max_light_samples}}}};
}

std::string Text(const Json& value) {
  return value.is_string() ? value.get<std::string>() : value.dump();
}

std::string TextAt(const Json& object, const char* name) {
  return object.contains(name) ? Text(object[name]) : "";
}

void PrintTechnique(const Json& technique, std::ostream& out) {
  out << TextAt(technique, "name") << "  " << TextAt(technique, "summary") << "\n  makes  "
      << TextAt(technique, "artifact_kind") << "\n  from   " << TextAt(technique, "source") << '\n';
  for (const Json& parameter : technique.value("parameters", Json::array())) {
    const std::string range = TextAt(parameter, "range");
    out << "  " << TextAt(parameter, "name") << "  " << TextAt(parameter, "type") << ", default "
        << TextAt(parameter, "default_value") << (range.empty() ? "" : ", ") << range << ": "
        << TextAt(parameter, "meaning") << '\n';
  }
}

// One line a leaf: "limits.max_lights  1024".
void PrintLeaves(const Json& value, const std::string& path, std::ostream& out) {
  if (!value.is_object()) {
    out << path << "  " << Text(value) << '\n';
    return;
  }
  for (const auto& [name, child] : value.items()) {
    PrintLeaves(child, path.empty() ? name : absl::StrCat(path, ".", name), out);
  }
}

// What the server is, and the names of its techniques.
absl::StatusOr<Json> ServerInfo(const EngineChoice& choice) {
  const auto engine = ConnectTo(choice);
  if (!engine.ok()) return engine.status();
  auto info = AskServer(**engine, &RemoteEngine::ServerInfoJson);
  if (!info.ok()) return info.status();
  const auto techniques = AskServer(**engine, &RemoteEngine::TechniquesJson);
  if (!techniques.ok()) return techniques.status();
  Json names = Json::array();
  for (const Json& technique : techniques->value("techniques", Json::array())) {
    names.push_back(TextAt(technique, "name"));
  }
  (*info)["techniques"] = std::move(names);
  (*info)["client"] = VersionText();
  return info;
}

void PrintSummary(const std::string& address, const Json& info, std::ostream& out) {
  const Json gl = info.value("gl", Json::object());
  const std::string gl_error = TextAt(gl, "error");
  out << TextAt(info, "server_name") << " at " << address << ", "
      << (gl_error.empty() ? "serving" : "serving degraded") << ", up "
      << DurationText(NumberAt(info, "uptime_ms") * 1e-3) << ", " << TextAt(info, "thread_count")
      << " threads\n"
      << "OpenGL: "
      << (gl_error.empty() ? absl::StrCat(TextAt(gl, "renderer"), ", ", TextAt(gl, "version"))
                           : absl::StrCat("none: ", gl_error))
      << '\n'
      << info["techniques"].size() << " techniques, "
      << CountersText(info.value("statistics", Json::object())) << "\n\n";
}

}  // namespace

absl::Status Run(const TechniquesCommand& command, const Console& console, std::stop_token) {
  absl::StatusOr<Json> json = LocalTechniques();
  if (!command.engine.server.empty()) {
    const auto engine = ConnectTo(command.engine);
    if (!engine.ok()) return engine.status();
    json = AskServer(**engine, &RemoteEngine::TechniquesJson);
  }
  if (!json.ok()) return json.status();
  if (command.json) {
    console.out << json->dump(2) << '\n';
    return absl::OkStatus();
  }
  for (const Json& technique : json->value("techniques", Json::array())) {
    PrintTechnique(technique, console.out);
  }
  return absl::OkStatus();
}

absl::Status Run(const InfoCommand& command, const Console& console, std::stop_token) {
  absl::StatusOr<Json> json = LocalInfo();
  if (!command.engine.server.empty()) {
    json = ServerInfo(command.engine);
  }
  if (!json.ok()) return json.status();
  if (command.json) {
    console.out << json->dump(2) << '\n';
    return absl::OkStatus();
  }
  if (!command.engine.server.empty()) PrintSummary(command.engine.server, *json, console.out);
  PrintLeaves(*json, "", console.out);
  return absl::OkStatus();
}

}  // namespace penumbra
