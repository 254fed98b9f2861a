#include "client/import/gltf/meshopt_view.h"

#include <meshoptimizer.h>

#include "absl/strings/str_cat.h"
#include "client/import/source_file.h"
#include "render/scene/field_error.h"

namespace penumbra::gltf {
namespace {

// The vertex codec spends at least 2 bits on 16 equal bytes, and the index codecs a byte on three
// indices or one, of at most 4 bytes.
constexpr uint64_t kMaxExpansion = 64;

absl::Status CheckShape(const MeshoptView& view, size_t packed_bytes, const std::string& path) {
  const bool attributes = view.mode == "ATTRIBUTES";
  if (attributes ? view.stride % 4 != 0 : view.stride != 2 && view.stride != 4) {
    return Malformed(
        "MESHOPT", path + ".byteStride",
        absl::StrCat("found ", view.stride, ", need ", attributes ? "a multiple of 4" : "2 or 4"));
  }
  if (view.mode == "TRIANGLES" && view.count % 3 != 0) {
    return Malformed("MESHOPT", path + ".count",
                     absl::StrCat("found ", view.count, ", need a multiple of 3"));
  }
  if (view.count * view.stride > kMaxExpansion * packed_bytes) {
    return FieldError(
        absl::StatusCode::kResourceExhausted, "EXPANSION", path + ".count",
        absl::StrCat("found ", view.count, " elements of ", view.stride, " bytes packed in ",
                     packed_bytes, ", need <= ", kMaxExpansion, " times as many bytes unpacked"));
  }
  return absl::OkStatus();
}

int Decode(const MeshoptView& view, std::span<const std::byte> packed, std::byte* out) {
  const auto* data = reinterpret_cast<const unsigned char*>(packed.data());
  if (view.mode == "ATTRIBUTES") {
    return meshopt_decodeVertexBuffer(out, view.count, view.stride, data, packed.size());
  }
  if (view.mode == "TRIANGLES") {
    return meshopt_decodeIndexBuffer(out, view.count, view.stride, data, packed.size());
  }
  return meshopt_decodeIndexSequence(out, view.count, view.stride, data, packed.size());
}

absl::Status Unfilter(const MeshoptView& view, std::byte* bytes, const std::string& path) {
  if (view.filter == "NONE") return absl::OkStatus();
  if (view.filter == "OCTAHEDRAL" && (view.stride == 4 || view.stride == 8)) {
    meshopt_decodeFilterOct(bytes, view.count, view.stride);
  } else if (view.filter == "QUATERNION" && view.stride == 8) {
    meshopt_decodeFilterQuat(bytes, view.count, view.stride);
  } else if (view.filter == "EXPONENTIAL" && view.stride % 4 == 0) {
    meshopt_decodeFilterExp(bytes, view.count, view.stride);
  } else if (view.filter == "COLOR") {
    return FieldError(absl::StatusCode::kUnimplemented, "MESHOPT", path + ".filter",
                      "found COLOR, need NONE, OCTAHEDRAL, QUATERNION or EXPONENTIAL");
  } else {
    return Malformed("MESHOPT", path + ".byteStride",
                     absl::StrCat("found ", view.stride, ", need one that ", view.filter, " has"));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::vector<std::byte>> DecodeMeshoptView(const MeshoptView& view,
                                                         std::span<const std::byte> packed,
                                                         std::string_view field_path) {
  const std::string path(field_path);
  absl::Status status = CheckShape(view, packed.size(), path);
  if (!status.ok()) return status;
  std::vector<std::byte> bytes(view.count * view.stride);
  if (view.count == 0) return bytes;
  // The low bits of the first byte are the codec's version; the library knows those of glTF's EXT.
  const int newest = view.mode == "ATTRIBUTES" ? 0 : 1;
  if (!packed.empty() && (std::to_integer<int>(packed[0]) & 0x0f) > newest) {
    return FieldError(absl::StatusCode::kUnimplemented, "MESHOPT", path,
                      absl::StrCat("found version ", std::to_integer<int>(packed[0]) & 0x0f,
                                   " of the ", view.mode, " codec, need <= ", newest));
  }
  if (packed.empty() || Decode(view, packed, bytes.data()) != 0) {
    return Malformed("MESHOPT", path, "found bytes that do not decode, need meshopt-packed ones");
  }
  status = Unfilter(view, bytes.data(), path);
  if (!status.ok()) return status;
  return bytes;
}

}  // namespace penumbra::gltf
