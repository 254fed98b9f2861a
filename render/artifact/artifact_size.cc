#include "render/artifact/artifact_size.h"

#include <variant>
#include <vector>

namespace penumbra {
namespace {

template <typename T>
size_t SizeOf(const std::vector<T>& values) {
  return values.size() * sizeof(T);
}

size_t BytesOf(const ShadowTexels& texels) {
  return SizeOf(texels.visibility.counts) +
         (texels.radiance ? SizeOf(texels.radiance->texels) : 0) +
         (texels.coverage ? texels.coverage->bytes().size() : 0);
}

size_t BytesOf(const AttenuationLdi& ldi) {
  size_t bytes = 0;
  for (const LdiFace& face : ldi.faces) {
    bytes += SizeOf(face.offsets) + SizeOf(face.depths) + SizeOf(face.counts);
  }
  return bytes;
}

size_t BytesOf(const ShadowWidthLayer& layer) {
  return SizeOf(layer.depths) + SizeOf(layer.widths);
}

size_t BytesOf(const ShadowWidthMap& map) {
  size_t bytes = 0;
  for (const ShadowWidthFace& face : map.faces) {
    bytes += BytesOf(face.near) + (face.far ? BytesOf(*face.far) : 0);
  }
  return bytes;
}

size_t BytesOf(const ShadowVolumeMesh& mesh) {
  size_t bytes = 0;
  for (const auto& volume : mesh.volumes) bytes += volume->bytes();
  return bytes;
}

}  // namespace

size_t BytesOf(const Artifact& artifact) {
  return sizeof(Artifact) + SizeOf(artifact.header.light_samples) +
         std::visit([](const auto& payload) { return BytesOf(payload); }, artifact.payload);
}

}  // namespace penumbra
