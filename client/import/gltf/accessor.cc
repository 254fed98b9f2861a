#include "client/import/gltf/accessor.h"

#include <algorithm>
#include <cstring>

#include "absl/strings/str_cat.h"
#include "client/import/source_file.h"
#include "render/scene/field_error.h"

namespace penumbra::gltf {
namespace {

template <typename T>
T LoadAs(const std::byte* from) {
  T value;
  std::memcpy(&value, from, sizeof(T));
  return value;
}

size_t ComponentBytes(int type) {
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return 1;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return 2;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
      return 4;
    default:
      return 0;
  }
}

// One component as a number. Source  glTF 2.0, §3.11, for the normalised ones.
float LoadFloat(const std::byte* from, int type, bool normalized) {
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE: {
      const float v = LoadAs<int8_t>(from);
      return normalized ? std::max(v / 127.0f, -1.0f) : v;
    }
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return LoadAs<uint8_t>(from) / (normalized ? 255.0f : 1.0f);
    case TINYGLTF_COMPONENT_TYPE_SHORT: {
      const float v = LoadAs<int16_t>(from);
      return normalized ? std::max(v / 32767.0f, -1.0f) : v;
    }
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return LoadAs<uint16_t>(from) / (normalized ? 65535.0f : 1.0f);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return static_cast<float>(LoadAs<uint32_t>(from));
    default:
      return LoadAs<float>(from);
  }
}

uint32_t LoadUnsigned(const std::byte* from, int type) {
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return LoadAs<uint8_t>(from);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return LoadAs<uint16_t>(from);
    default:
      return LoadAs<uint32_t>(from);
  }
}

bool IsUnsignedType(int type) {
  return type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
         type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
         type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
}

// `count` elements of `element_bytes` at `offset` of a view, `stride` apart.
struct Elements {
  std::span<const std::byte> bytes;
  uint64_t stride = 0;

  const std::byte* at(uint64_t i) const { return bytes.data() + i * stride; }
};

absl::StatusOr<Elements> ElementsOf(Document& document, int view, uint64_t offset, uint64_t count,
                                    uint64_t element_bytes, const std::string& path) {
  absl::StatusOr<std::span<const std::byte>> bytes = document.ViewBytes(view);
  if (!bytes.ok()) return bytes.status();
  const uint64_t declared = document.model().bufferViews[view].byteStride;
  const uint64_t stride = declared == 0 ? element_bytes : declared;
  if (stride < element_bytes) {
    return Malformed("SCHEMA", absl::StrCat("bufferViews[", view, "].byteStride"),
                     absl::StrCat("found ", stride, ", need >= ", element_bytes, " for ", path));
  }
  const uint64_t needed = count == 0 ? 0 : (count - 1) * stride + element_bytes;
  if (offset > bytes->size() || needed > bytes->size() - offset) {
    return Malformed("OUT_OF_BOUNDS", path + ".count",
                     absl::StrCat("found ", count, " elements, ", needed, " bytes at offset ",
                                  offset, ", need an end <= ", bytes->size(),
                                  ", the length of bufferViews[", view, "]"));
  }
  return Elements{.bytes = bytes->subspan(offset), .stride = stride};
}

absl::Status CheckCount(const Document& document, const tinygltf::Accessor& accessor,
                        const std::string& path) {
  // Indices: a mesh has three a triangle.
  const uint64_t most = std::max(document.limits().max_vertices_per_mesh,
                                 3 * document.limits().max_triangles_per_mesh);
  if (accessor.count > most) {
    return FieldError(absl::StatusCode::kResourceExhausted, "TOO_LARGE", path + ".count",
                      absl::StrCat("found ", accessor.count, ", need <= ", most));
  }
  if (ComponentBytes(accessor.componentType) == 0) {
    return Malformed(
        "SCHEMA", path + ".componentType",
        absl::StrCat("found ", accessor.componentType, ", need 5120 to 5123, 5125 or 5126"));
  }
  return absl::OkStatus();
}

// Calls store(element, bytes) for each element: the dense ones first, then those that replace them.
template <typename Store>
absl::Status ForEachElement(Document& document, const tinygltf::Accessor& accessor,
                            uint64_t element_bytes, const std::string& path, const Store& store) {
  if (document.HasView(accessor.bufferView)) {
    absl::StatusOr<Elements> dense = ElementsOf(document, accessor.bufferView, accessor.byteOffset,
                                                accessor.count, element_bytes, path);
    if (!dense.ok()) return dense.status();
    for (uint64_t i = 0; i < accessor.count; ++i) store(i, dense->at(i));
  }
  if (!accessor.sparse.isSparse) return absl::OkStatus();
  const auto& sparse = accessor.sparse;
  const uint64_t count = static_cast<uint64_t>(sparse.count);
  const std::string indices_path = path + ".sparse.indices";
  if (!IsUnsignedType(sparse.indices.componentType)) {
    return Malformed("SCHEMA", indices_path + ".componentType", "need 5121, 5123 or 5125");
  }
  absl::StatusOr<Elements> indices =
      ElementsOf(document, sparse.indices.bufferView, sparse.indices.byteOffset, count,
                 ComponentBytes(sparse.indices.componentType), indices_path);
  if (!indices.ok()) return indices.status();
  absl::StatusOr<Elements> values =
      ElementsOf(document, sparse.values.bufferView, sparse.values.byteOffset, count, element_bytes,
                 path + ".sparse.values");
  if (!values.ok()) return values.status();
  for (uint64_t i = 0; i < count; ++i) {
    const uint32_t element = LoadUnsigned(indices->at(i), sparse.indices.componentType);
    if (element >= accessor.count) {
      return Malformed("INDEX_RANGE", absl::StrCat(indices_path, "[", i, "]"),
                       absl::StrCat("found ", element, ", need < ", accessor.count));
    }
    store(element, values->at(i));
  }
  return absl::OkStatus();
}

// Matrices of one- and two-byte components have padded columns; nothing here reads such.
int ComponentCount(int type) {
  return type == TINYGLTF_TYPE_SCALAR ? 1 : tinygltf::GetNumComponentsInType(uint32_t(type));
}

}  // namespace

absl::StatusOr<FloatArray> ReadFloats(Document& document, int index,
                                      std::initializer_list<int> components,
                                      const std::string& field_path) {
  const tinygltf::Accessor& accessor = document.model().accessors[index];
  const std::string path = absl::StrCat("accessors[", index, "]");
  if (absl::Status status = CheckCount(document, accessor, path); !status.ok()) return status;
  const int count = ComponentCount(accessor.type);
  if (std::find(components.begin(), components.end(), count) == components.end()) {
    return Malformed("SCHEMA", path + ".type",
                     absl::StrCat("found elements of ", count, " numbers, need ",
                                  *components.begin(), " for ", field_path));
  }
  FloatArray out{.components = count, .values = {}};
  // Checked against the view first: a count alone must not allocate.
  const size_t component_bytes = ComponentBytes(accessor.componentType);
  if (document.HasView(accessor.bufferView)) {
    auto probe = ElementsOf(document, accessor.bufferView, accessor.byteOffset, accessor.count,
                            component_bytes * count, path);
    if (!probe.ok()) return probe.status();
  }
  out.values.resize(accessor.count * count);
  absl::Status status = ForEachElement(
      document, accessor, component_bytes * count, path, [&](uint64_t i, const std::byte* from) {
        for (int k = 0; k < count; ++k) {
          out.values[i * count + k] =
              LoadFloat(from + k * component_bytes, accessor.componentType, accessor.normalized);
        }
      });
  if (!status.ok()) return status;
  return out;
}

absl::StatusOr<std::vector<uint32_t>> ReadIndices(Document& document, int index,
                                                  const std::string& field_path) {
  const tinygltf::Accessor& accessor = document.model().accessors[index];
  const std::string path = absl::StrCat("accessors[", index, "]");
  if (absl::Status status = CheckCount(document, accessor, path); !status.ok()) return status;
  if (!IsUnsignedType(accessor.componentType) || ComponentCount(accessor.type) != 1) {
    return Malformed("SCHEMA", path + ".componentType",
                     absl::StrCat("found ", accessor.componentType,
                                  ", need SCALAR of 5121, 5123 or 5125 for ", field_path));
  }
  const size_t bytes = ComponentBytes(accessor.componentType);
  if (document.HasView(accessor.bufferView)) {
    auto probe =
        ElementsOf(document, accessor.bufferView, accessor.byteOffset, accessor.count, bytes, path);
    if (!probe.ok()) return probe.status();
  }
  std::vector<uint32_t> out(accessor.count);
  absl::Status status =
      ForEachElement(document, accessor, bytes, path, [&](uint64_t i, const std::byte* from) {
        out[i] = LoadUnsigned(from, accessor.componentType);
      });
  if (!status.ok()) return status;
  return out;
}

}  // namespace penumbra::gltf
