// The byte form of what is named by content hash: meshes and alpha masks. Little-endian.
//
//   mesh  "PNMM" u32 version=1 u32 V u32 3T u32 flags (1 = normals, 2 = uvs)
//         V × 3 f32 positions, [V × 3 f32 normals], [V × 2 f32 uvs], 3T × u32 indices
//   mask  "PNMA" u32 version=1 u32 width u32 height, width·height × u8 alpha, row 0 at v = 0
//
// A blob's name is the SHA-256 of these bytes, with every −0 written as 0.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <variant>
#include <vector>

#include "absl/status/statusor.h"
#include "render/scene/alpha_mask.h"
#include "render/scene/mesh.h"
#include "render/scene/scene_limits.h"

namespace penumbra {

std::vector<std::byte> EncodeBlob(const MeshGeometry& mesh);
std::vector<std::byte> EncodeBlob(const AlphaMask& mask);

using BlobContent = std::variant<std::shared_ptr<const Mesh>, std::shared_ptr<const AlphaMask>>;

// The bytes that EncodeBlob gives, read out of the content where it lies. Holds the content.
//
//   EncodedBlob blob(content);
//   for (size_t at = 0; at < blob.size(); at += n) blob.CopyTo(chunk, at, n);
class EncodedBlob {
 public:
  explicit EncodedBlob(BlobContent content);
  EncodedBlob(EncodedBlob&&) = default;  // not copied: the parts point into it

  size_t size() const { return size_; }
  // Bytes [from, from + count), all of them within the blob.
  void CopyTo(std::byte* out, size_t from, size_t count) const;

 private:
  BlobContent content_;
  std::vector<uint32_t> header_;
  std::vector<std::span<const std::byte>> parts_;  // in their order, the header first
  size_t size_ = 0;
};

// Errors  kInvalidArgument, reasons LENGTH, BLOB_FORMAT and those of Mesh::Create and
//         AlphaMask::Create; sizes are checked against `bytes` before anything is allocated.
absl::StatusOr<BlobContent> DecodeBlob(std::span<const std::byte> bytes,
                                       const SceneLimits& limits = {});

}  // namespace penumbra
