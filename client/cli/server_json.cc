#include "client/cli/server_json.h"

#include "absl/strings/numbers.h"

namespace penumbra {

using Json = nlohmann::ordered_json;

absl::StatusOr<Json> AskServer(RemoteEngine& engine,
                               absl::StatusOr<std::string> (RemoteEngine::*ask)()) {
  const auto text = (engine.*ask)();
  if (!text.ok()) return text.status();
  Json json = Json::parse(*text, nullptr, /*allow_exceptions=*/false);
  if (json.is_discarded()) return absl::InternalError("the server's answer does not read as JSON");
  return json;
}

double NumberAt(const Json& object, const char* name) {
  const auto found = object.find(name);
  if (found == object.end()) return 0;
  if (found->is_number()) return found->get<double>();
  double number = 0;
  if (found->is_string() && absl::SimpleAtod(found->get_ref<const std::string&>(), &number)) {
    return number;
  }
  return 0;
}

std::string TextAt(const nlohmann::ordered_json& object, const char* name) {
  const auto found = object.find(name);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

}  // namespace penumbra
