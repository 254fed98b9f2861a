#include "client/import/gltf/parse_document.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/import/gltf/rules.h"
#include "client/import/gltf/schema.h"
#include "client/import/source_file.h"
#include "render/scene/field_error.h"

namespace penumbra::gltf {
namespace {

using nlohmann::json;

// The longest real documents embed their buffers as base64.
constexpr size_t kMaxJsonBytes = size_t{512} << 20;
// glTF itself nests about ten deep; extras are free to, but recursion has to end.
constexpr size_t kMaxNesting = 64;
// A parsed value takes some 50 times the two bytes that it may take in the text.
constexpr size_t kMaxValues = 16'000'000;
// A thousand objects for each instance that a scene may hold is no scene.
constexpr size_t kMaxElements = 4'000'000;

// What a document may require: all that decides over shapes and places is known, and the rest of
// this list changes looks alone.
constexpr std::array<std::string_view, 30> kSupportedExtensions = {
    "EXT_lights_area",
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_texture_basisu",
    "KHR_texture_transform",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "MSFT_texture_dds",
    "EXT_texture_avif",
    "KHR_animation_pointer",
    "EXT_lights_image_based"};

absl::StatusOr<json> ParseJson(std::string_view text) {
  if (text.size() > kMaxJsonBytes) {
    return FieldError(absl::StatusCode::kResourceExhausted, "TOO_LARGE", "json",
                      absl::StrCat("found ", text.size(), " bytes, need <= ", kMaxJsonBytes));
  }
  const JsonSize size = MeasureJson(text);
  if (size.depth > kMaxNesting) {
    return Malformed(
        "DEPTH", "json",
        absl::StrCat("found values nested ", size.depth, " deep, need <= ", kMaxNesting));
  }
  if (size.values > kMaxValues) {
    return FieldError(absl::StatusCode::kResourceExhausted, "TOO_LARGE", "json",
                      absl::StrCat("found ", size.values, " values, need <= ", kMaxValues));
  }
  try {
    return json::parse(text);
  } catch (const json::exception& error) {
    std::string what = error.what();
    what.erase(0, std::min(what.find("] ") + 2, what.size()));
    return Malformed("JSON", "json",
                     absl::StrCat("found ", Quoted(what, 200), ", need a JSON document"));
  }
}

absl::Status CheckVersion(json& document) {
  const std::string version = document["asset"]["version"];
  const std::string required = document["asset"].value("minVersion", version);
  // A later minor version may be read by a reader of 2.0, unless it says otherwise.
  if (!version.starts_with("2.") || (required != version && required != "2.0")) {
    return FieldError(
        absl::StatusCode::kUnimplemented, "VERSION", "asset.version",
        absl::StrCat("found ", Quoted(version), " (at least ", Quoted(required), "), need 2.0"));
  }
  return absl::OkStatus();
}

absl::Status CheckExtensions(json& document) {
  if (!document.contains("extensionsRequired")) return absl::OkStatus();
  const json& required = document["extensionsRequired"];
  for (size_t i = 0; i < required.size(); ++i) {
    const std::string name = required[i];
    if (std::find(kSupportedExtensions.begin(), kSupportedExtensions.end(), name) ==
        kSupportedExtensions.end()) {
      return FieldError(absl::StatusCode::kUnimplemented, "EXTENSION",
                        absl::StrCat("extensionsRequired[", i, "]"),
                        absl::StrCat("found ", Quoted(name), ", need a supported extension"));
    }
  }
  return absl::OkStatus();
}

absl::Status CheckCounts(json& document) {
  for (const auto& [key, value] : std::as_const(document).items()) {
    if (value.is_array() && value.size() > kMaxElements) {
      return FieldError(absl::StatusCode::kResourceExhausted, "TOO_LARGE", key,
                        absl::StrCat("found ", value.size(), ", need <= ", kMaxElements));
    }
  }
  return absl::OkStatus();
}

absl::Status CheckRules(json& document) { return CheckSchema(document, DocumentRules()); }

}  // namespace

absl::StatusOr<json> ParseDocument(std::string_view text) {
  absl::StatusOr<json> document = ParseJson(text);
  if (!document.ok()) return document.status();
  for (const auto check : {CheckCounts, CheckRules, CheckVersion, CheckExtensions}) {
    absl::Status status = check(*document);
    if (!status.ok()) return status;
  }
  return document;
}

void StripForModel(json& document) {
  for (const char* key : {"buffers", "images", "animations", "samplers", "skins"}) {
    document.erase(key);
  }
  if (document.contains("textures")) {
    for (json& texture : document["textures"]) texture.erase("sampler");
  }
  if (!document.contains("accessors")) return;
  json& views = document["bufferViews"];
  const size_t absent = views.size();
  views.push_back({{"buffer", 0}, {"byteLength", 1}});
  for (json& accessor : document["accessors"]) {
    if (!accessor.contains("bufferView")) accessor["bufferView"] = absent;
  }
}

}  // namespace penumbra::gltf
