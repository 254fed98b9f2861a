// What a server says of itself, as JSON.
//
//   auto status = AskServer(engine, &RemoteEngine::ServerStatusJson);
//   double commits = NumberAt((*status)["statistics"], "commits");
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "absl/status/statusor.h"
#include "client/session/remote_engine.h"

namespace penumbra {

// Errors  those of RemoteEngine; kInternal: the answer is no JSON
absl::StatusOr<nlohmann::ordered_json> AskServer(
    RemoteEngine& engine, absl::StatusOr<std::string> (RemoteEngine::*ask)());

// A number that may be written as a text, as protobuf writes those of 64 bits; 0 where there is
// none.
double NumberAt(const nlohmann::ordered_json& object, const char* name);

// A text; empty where there is none.
std::string TextAt(const nlohmann::ordered_json& object, const char* name);

}  // namespace penumbra
