#include "render/scene/blob.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string_view>
#include <utility>

#include "absl/strings/str_cat.h"
#include "render/scene/field_error.h"

namespace penumbra {
namespace {

static_assert(std::endian::native == std::endian::little, "blobs are written in place");

constexpr uint32_t kMeshMagic = 0x4d4d4e50;  // "PNMM"
constexpr uint32_t kMaskMagic = 0x414d4e50;  // "PNMA"
constexpr uint32_t kVersion = 1;
constexpr uint32_t kHasNormals = 1;
constexpr uint32_t kHasUvs = 2;

using Header = std::vector<uint32_t>;
using Parts = std::vector<std::span<const std::byte>>;

Header HeaderOf(const MeshGeometry& mesh) {
  return {kMeshMagic, kVersion, static_cast<uint32_t>(mesh.positions.size()),
          static_cast<uint32_t>(mesh.indices.size()),
          (mesh.normals.empty() ? 0 : kHasNormals) | (mesh.uvs.empty() ? 0 : kHasUvs)};
}
Header HeaderOf(const AlphaMask& mask) {
  return {kMaskMagic, kVersion, mask.width(), mask.height()};
}

// Of what follows the header.
Parts PartsOf(const MeshGeometry& mesh) {
  return {std::as_bytes(std::span(mesh.positions)), std::as_bytes(std::span(mesh.normals)),
          std::as_bytes(std::span(mesh.uvs)), std::as_bytes(std::span(mesh.indices))};
}
Parts PartsOf(const AlphaMask& mask) { return {std::as_bytes(std::span(mask.alpha()))}; }

template <typename T>
std::vector<std::byte> Encode(const T& content) {
  const Header header = HeaderOf(content);
  const auto head = std::as_bytes(std::span(header));
  const Parts parts = PartsOf(content);
  size_t size = head.size();
  for (const auto part : parts) size += part.size();
  std::vector<std::byte> bytes(size);
  std::byte* out = std::copy(head.begin(), head.end(), bytes.data());
  for (const auto part : parts) out = std::copy(part.begin(), part.end(), out);
  return bytes;
}

class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : rest_(bytes) {}

  size_t left() const { return rest_.size(); }
  std::optional<uint32_t> Take() {
    if (rest_.size() < sizeof(uint32_t)) return std::nullopt;
    uint32_t value;
    std::memcpy(&value, rest_.data(), sizeof(value));
    rest_ = rest_.subspan(sizeof(value));
    return value;
  }
  // The caller has checked that `count` values are left.
  template <typename T>
  std::vector<T> TakeVector(size_t count) {
    std::vector<T> values(count);
    if (count != 0) std::memcpy(values.data(), rest_.data(), count * sizeof(T));
    rest_ = rest_.subspan(count * sizeof(T));
    return values;
  }

 private:
  std::span<const std::byte> rest_;
};

absl::Status LengthError(uint64_t found, uint64_t need) {
  return FieldError(absl::StatusCode::kInvalidArgument, "LENGTH", "blob",
                    absl::StrCat("found ", found, " bytes after the header, need ", need));
}

absl::Status FormatError(std::string_view found_and_need) {
  return FieldError(absl::StatusCode::kInvalidArgument, "BLOB_FORMAT", "blob", found_and_need);
}

absl::StatusOr<BlobContent> DecodeMesh(Reader reader, const SceneLimits& limits) {
  const auto vertices = reader.Take();
  const auto indices = reader.Take();
  const auto flags = reader.Take();
  if (!flags) return FormatError("found a mesh cut off in its header, need 20 bytes");
  if (*flags & ~(kHasNormals | kHasUvs)) {
    return FormatError(absl::StrCat("found mesh flags ", *flags, ", need at most 3"));
  }
  const uint64_t bytes_per_vertex =
      12 + (*flags & kHasNormals ? 12 : 0) + (*flags & kHasUvs ? 8 : 0);
  const uint64_t need = uint64_t{*vertices} * bytes_per_vertex + uint64_t{*indices} * 4;
  if (reader.left() != need) return LengthError(reader.left(), need);
  MeshGeometry geometry;
  geometry.positions = reader.TakeVector<Vec3>(*vertices);
  if (*flags & kHasNormals) geometry.normals = reader.TakeVector<Vec3>(*vertices);
  if (*flags & kHasUvs) geometry.uvs = reader.TakeVector<Vec2>(*vertices);
  geometry.indices = reader.TakeVector<uint32_t>(*indices);
  return Mesh::Create(std::move(geometry), limits);
}

absl::StatusOr<BlobContent> DecodeMask(Reader reader, const SceneLimits& limits) {
  const auto width = reader.Take();
  const auto height = reader.Take();
  if (!height) return FormatError("found a mask cut off in its header, need 16 bytes");
  const uint64_t need = uint64_t{*width} * *height;
  if (reader.left() != need) return LengthError(reader.left(), need);
  return AlphaMask::Create(*width, *height, reader.TakeVector<uint8_t>(need), limits);
}

}  // namespace

std::vector<std::byte> EncodeBlob(const MeshGeometry& mesh) { return Encode(mesh); }

std::vector<std::byte> EncodeBlob(const AlphaMask& mask) { return Encode(mask); }

EncodedBlob::EncodedBlob(BlobContent content) : content_(std::move(content)) {
  const auto lay_out = [this](const auto& blob) {
    header_ = HeaderOf(blob);
    parts_ = PartsOf(blob);
  };
  if (const auto* mesh = std::get_if<std::shared_ptr<const Mesh>>(&content_)) {
    lay_out((*mesh)->geometry());
  } else {
    lay_out(*std::get<std::shared_ptr<const AlphaMask>>(content_));
  }
  parts_.insert(parts_.begin(), std::as_bytes(std::span(header_)));
  for (const auto part : parts_) size_ += part.size();
}

void EncodedBlob::CopyTo(std::byte* out, size_t from, size_t count) const {
  for (const auto part : parts_) {
    if (from >= part.size()) {
      from -= part.size();
      continue;
    }
    const size_t here = std::min(count, part.size() - from);
    if (here != 0) std::memcpy(out, part.data() + from, here);
    out += here;
    count -= here;
    from = 0;
  }
}

absl::StatusOr<BlobContent> DecodeBlob(std::span<const std::byte> bytes,
                                       const SceneLimits& limits) {
  Reader reader(bytes);
  const auto magic = reader.Take();
  const auto version = reader.Take();
  if (!version || (*magic != kMeshMagic && *magic != kMaskMagic)) {
    return FormatError("found bytes that start with neither PNMM nor PNMA, need a mesh or a mask");
  }
  if (*version != kVersion) {
    return FormatError(absl::StrCat("found version ", *version, ", need ", kVersion));
  }
  return *magic == kMeshMagic ? DecodeMesh(reader, limits) : DecodeMask(reader, limits);
}

}  // namespace penumbra
