// From JSON text to a document that tinygltf can be trusted with.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string_view>

#include "absl/status/statusor.h"

namespace penumbra::gltf {

// Parses `text` and checks it: size, nesting, DocumentRules(), version, required extensions.
//
// Errors  kInvalidArgument, reasons JSON, DEPTH, SCHEMA; kUnimplemented, reasons VERSION,
// EXTENSION;
//         kResourceExhausted, reason TOO_LARGE
absl::StatusOr<nlohmann::json> ParseDocument(std::string_view text);

// Takes out what tinygltf would load, decode or trip over, and this importer does not read from it.
// Gives accessors that have no view one past the last, as tinygltf knows no indices without.
void StripForModel(nlohmann::json& document);

}  // namespace penumbra::gltf
