#include "client/import/gltf/document.h"

#include <algorithm>
#include <array>
#include <climits>
#include <nlohmann/json.hpp>

#include "absl/strings/str_cat.h"
#include "client/import/gltf/container.h"
#include "client/import/gltf/meshopt_view.h"
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
  if (const size_t depth = NestingDepth(text); depth > kMaxNesting) {
    return Malformed("DEPTH", "json",
                     absl::StrCat("found values nested ", depth, " deep, need <= ", kMaxNesting));
  }
  try {
    return json::parse(text);
  } catch (const json::exception& error) {
    std::string what = error.what();
    what.erase(0, std::min(what.find("] ") + 2, what.size()));
    return Malformed("JSON", "json",
                     absl::StrCat("found ", Quoted(what.substr(0, 160)), ", need a JSON document"));
  }
}

absl::Status CheckVersion(const json& document) {
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

absl::Status CheckExtensions(const json& document) {
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

absl::Status CheckCounts(const json& document) {
  for (const auto& [key, value] : document.items()) {
    if (value.is_array() && value.size() > kMaxElements) {
      return FieldError(absl::StatusCode::kResourceExhausted, "TOO_LARGE", key,
                        absl::StrCat("found ", value.size(), ", need <= ", kMaxElements));
    }
  }
  return absl::OkStatus();
}

std::optional<std::string> OptionalString(const json& object, const char* key) {
  const auto value = object.find(key);
  return value == object.end() ? std::nullopt : std::optional<std::string>(*value);
}

// Takes out what tinygltf would load, decode or trip over, and this importer does not read from it.
void StripForModel(json& document) {
  for (const char* key : {"buffers", "images", "animations", "samplers", "skins"}) {
    document.erase(key);
  }
  if (document.contains("textures")) {
    for (json& texture : document["textures"]) texture.erase("sampler");
  }
}

}  // namespace

const tinygltf::Value* FindExtension(const tinygltf::ExtensionMap& extensions,
                                     const std::string& name) {
  const auto found = extensions.find(name);
  return found == extensions.end() ? nullptr : &found->second;
}

double NumberOr(const tinygltf::Value& object, const std::string& key, double fallback) {
  return object.Has(key) ? object.Get(key).GetNumberAsDouble() : fallback;
}

absl::StatusOr<std::unique_ptr<Document>> Document::Open(const std::filesystem::path& path,
                                                         const SceneLimits& limits) {
  std::unique_ptr<Document> document(new Document);
  document->folder_ = path.parent_path();
  document->limits_ = limits;
  absl::StatusOr<std::vector<std::byte>> bytes = ReadFile(path);
  if (!bytes.ok()) return bytes.status();
  document->file_ = *std::move(bytes);
  absl::StatusOr<Container> container = SplitContainer(document->file_);
  if (!container.ok()) return container.status();
  document->bin_ = container->bin;
  absl::Status status = document->Parse(container->json);
  if (!status.ok()) return status;
  return document;
}

absl::Status Document::Parse(std::string_view json_text) {
  absl::StatusOr<json> document = ParseJson(json_text);
  if (!document.ok()) return document.status();
  if (absl::Status status = CheckCounts(*document); !status.ok()) return status;
  if (absl::Status status = CheckSchema(*document, DocumentRules()); !status.ok()) return status;
  if (absl::Status status = CheckVersion(*document); !status.ok()) return status;
  if (absl::Status status = CheckExtensions(*document); !status.ok()) return status;

  for (const json& buffer : document->value("buffers", json::array())) {
    SourceBuffer source;
    source.uri = OptionalString(buffer, "uri");
    source.length = buffer["byteLength"].get<uint64_t>();
    buffers_.push_back(std::move(source));
  }
  for (const json& image : document->value("images", json::array())) {
    images_.push_back({.uri = OptionalString(image, "uri"), .view = image.value("bufferView", -1)});
  }
  for (const json& skin : document->value("skins", json::array())) {
    skins_.push_back({.joints = skin.value("joints", std::vector<int>()),
                      .inverse_bind_matrices = skin.value("inverseBindMatrices", -1)});
  }
  StripForModel(*document);

  const std::string text = document->dump();
  if (text.size() > INT_MAX) {
    return FieldError(absl::StatusCode::kResourceExhausted, "TOO_LARGE", "json",
                      "found more than 2 GiB, need less");
  }
  std::string error, warning;
  try {
    if (tinygltf::TinyGLTF().LoadASCIIFromString(&model_, &error, &warning, text.data(),
                                                 static_cast<unsigned int>(text.size()), "")) {
      return absl::OkStatus();
    }
  } catch (const std::exception& exception) {
    error = exception.what();
  }
  return Malformed("GLTF", "json",
                   absl::StrCat("found ", Quoted(error), ", need a glTF 2.0 document"));
}

absl::StatusOr<std::span<const std::byte>> Document::BufferBytes(int buffer) {
  SourceBuffer& source = buffers_[buffer];
  const std::string path = absl::StrCat("buffers[", buffer, "]");
  if (!source.loaded) {
    if (source.uri) {
      absl::StatusOr<std::vector<std::byte>> file = ReadUri(folder_, *source.uri, path + ".uri");
      if (!file.ok()) return file.status();
      source.file = *std::move(file);
      source.content = source.file;
    } else if (buffer == 0 && bin_) {
      source.content = *bin_;
    } else {
      return Malformed("NO_BUFFER", path + ".uri", "found nothing, need a uri or a BIN chunk");
    }
    source.loaded = true;
  }
  if (source.content.size() < source.length) {
    return Malformed("LENGTH", path + ".byteLength",
                     absl::StrCat("found ", source.length, ", need <= ", source.content.size(),
                                  ", what the buffer holds"));
  }
  return source.content.first(source.length);
}

absl::StatusOr<std::span<const std::byte>> Document::Slice(int buffer, uint64_t offset,
                                                           uint64_t length,
                                                           const std::string& path) {
  absl::StatusOr<std::span<const std::byte>> bytes = BufferBytes(buffer);
  if (!bytes.ok()) return bytes.status();
  if (offset > bytes->size() || length > bytes->size() - offset) {
    return Malformed("OUT_OF_BOUNDS", path + ".byteLength",
                     absl::StrCat("found ", length, " at offset ", offset, ", need an end <= ",
                                  bytes->size(), ", the length of buffers[", buffer, "]"));
  }
  return bytes->subspan(offset, length);
}

absl::StatusOr<std::span<const std::byte>> Document::ViewBytes(int view) {
  const tinygltf::BufferView& source = model_.bufferViews[view];
  const std::string path = absl::StrCat("bufferViews[", view, "]");
  for (const char* name : {"EXT_meshopt_compression", "KHR_meshopt_compression"}) {
    const tinygltf::Value* extension = FindExtension(source.extensions, name);
    if (extension == nullptr || !extension->Has("buffer")) continue;
    auto bytes = Decompressed(view, *extension, absl::StrCat(path, ".extensions.", name));
    // The buffer itself may hold the same uncompressed, for readers that do not know the codec.
    if (bytes.ok() || !buffers_[source.buffer].uri) return bytes;
  }
  return Slice(source.buffer, source.byteOffset, source.byteLength, path);
}

absl::StatusOr<std::span<const std::byte>> Document::Decompressed(int view,
                                                                  const tinygltf::Value& extension,
                                                                  const std::string& path) {
  if (const auto known = decompressed_views_.find(view); known != decompressed_views_.end()) {
    return std::span<const std::byte>(known->second);
  }
  const auto number = [&extension](const char* key) {
    return static_cast<uint64_t>(NumberOr(extension, key, 0.0));
  };
  absl::StatusOr<std::span<const std::byte>> packed =
      Slice(static_cast<int>(number("buffer")), number("byteOffset"), number("byteLength"), path);
  if (!packed.ok()) return packed.status();
  absl::StatusOr<std::vector<std::byte>> bytes = DecodeMeshoptView(
      {.count = number("count"),
       .stride = number("byteStride"),
       .mode = extension.Get("mode").Get<std::string>(),
       .filter = extension.Has("filter") ? extension.Get("filter").Get<std::string>() : "NONE"},
      *packed, path);
  if (!bytes.ok()) return bytes.status();
  return std::span<const std::byte>(
      decompressed_views_.emplace(view, *std::move(bytes)).first->second);
}

absl::StatusOr<std::vector<std::byte>> Document::ImageFile(int image) {
  const SourceImage& source = images_[image];
  const std::string path = absl::StrCat("images[", image, "]");
  if (source.uri) return ReadUri(folder_, *source.uri, path + ".uri");
  if (source.view < 0) {
    return Malformed("NO_IMAGE", path, "found neither uri nor bufferView, need one");
  }
  absl::StatusOr<std::span<const std::byte>> bytes = ViewBytes(source.view);
  if (!bytes.ok()) return bytes.status();
  return std::vector<std::byte>(bytes->begin(), bytes->end());
}

}  // namespace penumbra::gltf
