// Meshes and alpha masks on the GPU.
#pragma once

#include <memory>
#include <optional>

#include "absl/container/flat_hash_map.h"
#include "absl/status/statusor.h"
#include "render/gl/buffer.h"
#include "render/gl/context.h"
#include "render/gl/texture.h"
#include "render/gl/vertex_array.h"
#include "render/scene/alpha_mask.h"
#include "render/scene/content_hash.h"
#include "render/scene/mesh.h"

namespace penumbra {

struct GpuMesh {
  // Errors  kResourceExhausted: GPU memory
  static absl::StatusOr<GpuMesh> Create(gl::Context& context, const Mesh& mesh);

  int index_count = 0;
  bool has_normals = false;
  bool has_face_normals = false;  // absent where one storage block cannot hold them
  gl::VertexArray vertices;
  gl::Buffer positions, normals, uvs, indices;
  gl::Buffer face_normals;  // three floats a triangle, mesh space, of any length
};

absl::StatusOr<gl::Texture> CreateMaskTexture(gl::Context& context, const AlphaMask& mask);

// What was uploaded, by content: asked for again it is there. What was not asked for between two
// calls of EndFrame is dropped at the second.
template <typename Gpu>
class UploadCache {
 public:
  // The uploaded form of `content`, made by `upload` (→ StatusOr<Gpu>) when it is new.
  template <typename Content, typename Upload>
  absl::StatusOr<Gpu*> Find(const Content& content, const Upload& upload) {
    auto it = entries_.find(content.id());
    if (it == entries_.end()) {
      absl::StatusOr<Gpu> made = upload(content);
      if (!made.ok()) return made.status();
      ++upload_count_;
      it = entries_.emplace(content.id(), std::make_unique<Entry>(*std::move(made))).first;
    }
    it->second->is_used = true;
    return &it->second->gpu;
  }

  void EndFrame() {
    absl::erase_if(entries_,
                   [](auto& entry) { return !std::exchange(entry.second->is_used, false); });
  }
  void Clear() { entries_.clear(); }
  int64_t upload_count() const { return upload_count_; }

 private:
  struct Entry {
    explicit Entry(Gpu&& made) : gpu(std::move(made)) {}
    Gpu gpu;
    bool is_used = false;
  };

  absl::flat_hash_map<ContentHash, std::unique_ptr<Entry>> entries_;
  int64_t upload_count_ = 0;
};

}  // namespace penumbra
