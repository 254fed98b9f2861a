// A glTF document, checked, with the bytes of its buffer views at hand.
//
//   auto document = Document::Open("table.glb", limits);
//   auto bytes = (*document)->ViewBytes(accessor.bufferView);
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "render/scene/scene_limits.h"
#include "tiny_gltf.h"

namespace penumbra::gltf {

struct Skin {
  std::vector<int> joints;         // nodes
  int inverse_bind_matrices = -1;  // accessor, or -1: identities
};

class Document {
 public:
  // Reads the container, checks the JSON against DocumentRules() and has tinygltf make the model of
  // it: so all indices in `model()` are in range. Buffers and images are left to the functions
  // below; tinygltf opens no file and decodes nothing.
  //
  // Errors  as ImportScene
  static absl::StatusOr<std::unique_ptr<Document>> Open(const std::filesystem::path& path,
                                                        const SceneLimits& limits);

  Document(const Document&) = delete;
  Document& operator=(const Document&) = delete;

  const tinygltf::Model& model() const { return model_; }
  const SceneLimits& limits() const { return limits_; }
  const std::vector<Skin>& skins() const { return skins_; }
  // Whether `view` is one of the document's; accessors without one are full of zeros.
  bool HasView(int view) const { return view >= 0 && view < view_count_; }
  size_t image_count() const { return images_.size(); }

  // The bytes of a buffer view, decompressed where it is compressed. The span lives as long as the
  // document.
  //
  // Errors  kInvalidArgument: the view leaves its buffer, or does not decode; kNotFound;
  //         kPermissionDenied; kResourceExhausted
  absl::StatusOr<std::span<const std::byte>> ViewBytes(int view);

  // The file that image `image` holds, undecoded.
  absl::StatusOr<std::vector<std::byte>> ImageFile(int image);

 private:
  struct SourceBuffer {
    std::optional<std::string> uri;
    uint64_t length = 0;
    bool fallback = false;  // for readers that know no compression; may be missing
    bool loaded = false;
    std::vector<std::byte> file;         // what the uri holds
    std::span<const std::byte> content;  // of `file` or of the BIN chunk
  };
  struct SourceImage {
    std::optional<std::string> uri;
    int view = -1;
  };

  Document() = default;
  absl::Status Parse(std::string_view json_text);
  absl::Status CheckBuffers();
  absl::StatusOr<std::span<const std::byte>> BufferBytes(int buffer);
  // Errors name `path`.offset, .length and so on.
  absl::StatusOr<std::span<const std::byte>> Slice(int buffer, uint64_t offset, uint64_t length,
                                                   const std::string& path);
  absl::StatusOr<std::span<const std::byte>> Decompressed(int view,
                                                          const tinygltf::Value& extension,
                                                          const std::string& path);

  std::filesystem::path folder_;
  SceneLimits limits_;
  std::vector<std::byte> file_;
  std::optional<std::span<const std::byte>> bin_;
  std::vector<SourceBuffer> buffers_;
  std::vector<SourceImage> images_;
  std::vector<Skin> skins_;
  int view_count_ = 0;
  std::map<int, std::vector<std::byte>> decompressed_views_;
  tinygltf::Model model_;
};

// The extension `name` of a part of the model; null when it has none.
const tinygltf::Value* FindExtension(const tinygltf::ExtensionMap& extensions,
                                     const std::string& name);

// A number of an extension, or `fallback`.
double NumberOr(const tinygltf::Value& object, const std::string& key, double fallback);

}  // namespace penumbra::gltf
