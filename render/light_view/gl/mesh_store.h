// The meshes and alpha masks that a GL context holds, by their content hash.
//
//   auto mesh = MeshStore::Of(context).Mesh(context, *instance->mesh, "soft_texture.method");
//   (*mesh)->Bind(context);   // uploaded unless it was there
#pragma once

#include <list>
#include <map>
#include <string_view>
#include <utility>
#include <variant>

#include "absl/status/statusor.h"
#include "render/gl/buffer.h"
#include "render/gl/context.h"
#include "render/gl/texture.h"
#include "render/scene/alpha_mask.h"
#include "render/scene/mesh.h"

namespace penumbra {

// Where shaders find a mesh's storage blocks, and its mask's texture.
inline constexpr int kPositionsBinding = 0, kIndicesBinding = 1, kUvsBinding = 2;
inline constexpr int kMaskUnit = 0;

struct GpuMesh {
  gl::Buffer positions, indices, uvs;

  void Bind(gl::Context& context) const;
};

// What was asked for longest ago goes first when room is needed.
class MeshStore {
 public:
  static constexpr size_t kMaxKeptBytes = size_t{256} << 20;

  // The one of `context`, which all that draw there share. Keeps kMaxKeptBytes, or half of the
  // context's memory where that is less: the other half is to draw with.
  static MeshStore& Of(gl::Context& context);

  explicit MeshStore(size_t max_bytes) : max_bytes_(max_bytes) {}

  // What is returned stays until the next call; what was drawn from it before is not affected by
  // its going.
  //
  // field   that asked for GL, for errors
  // Errors  kResourceExhausted, GL_MEMORY: it is larger than all that may be kept, or than the
  //         driver allows; and those of gl::Buffer and gl::Texture
  absl::StatusOr<const GpuMesh*> Mesh(gl::Context& context, const penumbra::Mesh& mesh,
                                      std::string_view field);
  // The same; `beside`, a mesh that was asked for last, stays too.
  absl::StatusOr<const gl::Texture*> Mask(gl::Context& context, const AlphaMask& mask,
                                          const penumbra::Mesh& beside, std::string_view field);

  size_t bytes() const { return bytes_; }
  size_t upload_count() const { return upload_count_; }

 private:
  struct Entry {
    ContentHash id;
    size_t bytes;
    std::variant<GpuMesh, gl::Texture> content;
  };
  using Entries = std::list<Entry>;

  // The entry of that id, moved to the front; null if there is none.
  Entry* Find(const ContentHash& id);
  // Drops entries until `bytes` more fit beside `pinned`, which may be null and is the first entry.
  absl::Status MakeRoom(size_t bytes, size_t limit, const ContentHash* pinned, const char* what,
                        std::string_view field);
  Entry& Add(Entry entry);

  const size_t max_bytes_;
  size_t bytes_ = 0;
  size_t upload_count_ = 0;
  Entries entries_;  // asked for last first
  std::map<ContentHash, Entries::iterator> by_id_;
};

// The least value of 8 bits that is at least `cutoff` as a share of 255; 256 if there is none.
int LeastAlpha(float cutoff);

}  // namespace penumbra
