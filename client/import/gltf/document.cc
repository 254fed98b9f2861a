#include "client/import/gltf/document.h"

#include <climits>
#include <nlohmann/json.hpp>

#include "absl/strings/str_cat.h"
#include "client/import/gltf/container.h"
#include "client/import/gltf/meshopt_view.h"
#include "client/import/gltf/parse_document.h"
#include "client/import/source_file.h"
#include "render/scene/field_error.h"

namespace penumbra::gltf {
namespace {

using nlohmann::json;

std::optional<std::string> OptionalString(const json& object, const char* key) {
  const auto value = object.find(key);
  return value == object.end() ? std::nullopt : std::optional<std::string>(*value);
}

bool IsFallback(const json& buffer) {
  const json extensions = buffer.value("extensions", json::object());
  return extensions.contains("EXT_meshopt_compression") ||
         extensions.contains("KHR_meshopt_compression");
}

absl::Status LoadModel(const std::string& text, tinygltf::Model& model) {
  if (text.size() > INT_MAX) {
    return FieldError(absl::StatusCode::kResourceExhausted, "TOO_LARGE", "json",
                      "found more than 2 GiB, need less");
  }
  std::string error, warning;
  try {
    if (tinygltf::TinyGLTF().LoadASCIIFromString(&model, &error, &warning, text.data(),
                                                 static_cast<unsigned int>(text.size()), "")) {
      return absl::OkStatus();
    }
  } catch (const std::exception& exception) {
    error = exception.what();
  }
  return Malformed("GLTF", "json",
                   absl::StrCat("found ", Quoted(error, 200), ", need a glTF 2.0 document"));
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
  absl::StatusOr<json> document = ParseDocument(json_text);
  if (!document.ok()) return document.status();
  for (const json& buffer : document->value("buffers", json::array())) {
    SourceBuffer source{.uri = OptionalString(buffer, "uri"),
                        .length = buffer["byteLength"].get<uint64_t>(),
                        .fallback = IsFallback(buffer)};
    buffers_.push_back(std::move(source));
  }
  for (const json& image : document->value("images", json::array())) {
    images_.push_back({.uri = OptionalString(image, "uri"), .view = image.value("bufferView", -1)});
  }
  for (const json& skin : document->value("skins", json::array())) {
    skins_.push_back({.joints = skin.value("joints", std::vector<int>()),
                      .inverse_bind_matrices = skin.value("inverseBindMatrices", -1)});
  }
  view_count_ = static_cast<int>(document->value("bufferViews", json::array()).size());
  StripForModel(*document);
  absl::Status status = LoadModel(document->dump(), model_);
  return status.ok() ? CheckBuffers() : status;
}

absl::Status Document::CheckBuffers() {
  uint64_t read = 0;
  for (size_t i = 0; i < buffers_.size(); ++i) {
    const bool has_content = buffers_[i].uri || (i == 0 && bin_);
    if (!has_content || buffers_[i].fallback) continue;
    absl::Status status = BufferBytes(static_cast<int>(i)).status();
    if (!status.ok()) return status;
    // Many buffers may name one file.
    read += buffers_[i].file.size();
    if (read > kMaxSourceFileBytes) {
      return FieldError(absl::StatusCode::kResourceExhausted, "TOO_LARGE", "buffers",
                        absl::StrCat("found more than ", kMaxSourceFileBytes,
                                     " bytes in the first ", i + 1, ", need no more in all"));
    }
  }
  for (int i = 0; i < view_count_; ++i) {
    const tinygltf::BufferView& view = model_.bufferViews[i];
    const uint64_t length = buffers_[view.buffer].length;
    if (view.byteOffset > length || view.byteLength > length - view.byteOffset) {
      return Malformed(
          "OUT_OF_BOUNDS", absl::StrCat("bufferViews[", i, "].byteLength"),
          absl::StrCat("found ", view.byteLength, " at offset ", view.byteOffset,
                       ", need an end <= ", length, ", buffers[", view.buffer, "].byteLength"));
    }
  }
  return absl::OkStatus();
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
