#include "client/display/gpu_mesh.h"

#include <utility>
#include <vector>

namespace penumbra {
namespace {

// Locations of the surface program's vertex shader.
constexpr uint32_t kPosition = 0, kNormal = 1, kUv = 2;

// Twice the area times the normal of each triangle, scaled so that small triangles keep their
// direction.
std::vector<Vec3> FaceNormals(const Mesh& mesh) {
  std::vector<Vec3> normals;
  normals.reserve(mesh.triangle_count());
  for (size_t t = 0; t < mesh.triangle_count(); ++t) {
    const auto corner = [&](size_t i) {
      return DVec3(mesh.positions()[mesh.indices()[3 * t + i]]);
    };
    const DVec3 n = glm::cross(corner(1) - corner(0), corner(2) - corner(0));
    const double length = glm::length(n);
    normals.emplace_back(length > 0 ? Vec3(n / length) : Vec3(0));
  }
  return normals;
}

}  // namespace

absl::StatusOr<GpuMesh> GpuMesh::Create(gl::Context& context, const Mesh& mesh) {
  GpuMesh gpu;
  gpu.index_count = static_cast<int>(mesh.indices().size());
  gpu.has_normals = !mesh.normals().empty();
  const size_t face_normal_bytes = mesh.triangle_count() * sizeof(Vec3);
  gpu.has_face_normals = face_normal_bytes <= static_cast<size_t>(context.info().max_storage_bytes);
  auto vertices = gl::VertexArray::Create(context);
  if (!vertices.ok()) return vertices.status();
  gpu.vertices = *std::move(vertices);

  const std::vector<Vec3> faces = gpu.has_face_normals ? FaceNormals(mesh) : std::vector<Vec3>();
  const struct {
    gl::Buffer& buffer;
    std::span<const std::byte> content;
  } uploads[] = {{gpu.positions, std::as_bytes(mesh.positions())},
                 {gpu.normals, std::as_bytes(mesh.normals())},
                 {gpu.uvs, std::as_bytes(mesh.uvs())},
                 {gpu.indices, std::as_bytes(mesh.indices())},
                 {gpu.face_normals, std::as_bytes(std::span(faces))}};
  for (const auto& upload : uploads) {
    auto buffer = gl::Buffer::Create(context, upload.content);
    if (!buffer.ok()) return buffer.status();
    upload.buffer = *std::move(buffer);
  }
  gpu.vertices.SetFloats(context, kPosition, gpu.positions, 3);
  if (gpu.has_normals) gpu.vertices.SetFloats(context, kNormal, gpu.normals, 3);
  if (!mesh.uvs().empty()) gpu.vertices.SetFloats(context, kUv, gpu.uvs, 2);
  gpu.vertices.SetIndices(context, gpu.indices);
  return gpu;
}

absl::StatusOr<gl::Texture> CreateMaskTexture(gl::Context& context, const AlphaMask& mask) {
  auto texture = gl::Texture::Create(context, {.width = static_cast<int>(mask.width()),
                                               .height = static_cast<int>(mask.height()),
                                               .format = gl::Format::kR8});
  if (!texture.ok()) return texture.status();
  if (absl::Status status = texture->Write(context, std::as_bytes(mask.alpha())); !status.ok()) {
    return status;
  }
  return texture;
}

}  // namespace penumbra
