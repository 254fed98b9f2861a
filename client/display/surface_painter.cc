#include "client/display/surface_painter.h"

#include <algorithm>
#include <utility>

namespace penumbra {
namespace {

DMat4 Matrix(const Affine& m) {
  return DMat4(DVec4(m[0], 0), DVec4(m[1], 0), DVec4(m[2], 0), DVec4(m[3], 1));
}

// Takes normals along: the cofactors, which unlike the inverse exist for every map. Scaled, because
// only directions matter and products of large scales would overflow.
Mat4 NormalMatrix(const Affine& m) {
  const DVec3 x(m[0]), y(m[1]), z(m[2]);
  DVec3 columns[3] = {glm::cross(y, z), glm::cross(z, x), glm::cross(x, y)};
  double largest = 0;
  for (const DVec3& c : columns) largest = std::max(largest, glm::length(c));
  const double scale = largest > 0 ? 1 / largest : 0;
  return Mat4(Vec4(Vec3(scale * columns[0]), 0), Vec4(Vec3(scale * columns[1]), 0),
              Vec4(Vec3(scale * columns[2]), 0), Vec4(0, 0, 0, 1));
}

}  // namespace

absl::Status SurfacePainter::Bind(gl::Context& context) {
  meshes_.Clear();
  masks_.Clear();
  auto surface = gl::Program::Create(context, surface_source_);
  if (!surface.ok()) return surface.status();
  auto glow = gl::Program::Create(context, GlowProgram());
  if (!glow.ok()) return glow.status();
  surface_ = *std::move(surface);
  glow_ = *std::move(glow);
  return absl::OkStatus();
}

void SurfacePainter::SetFrame(gl::Context& context, const Camera& camera,
                              const SurfaceFrame& frame) {
  for (gl::Program* program : {&*surface_, &*glow_}) {
    program->Set(context, "eye", camera.eye);
    program->Set(context, "clip_radiance", frame.clip_radiance);
  }
  surface_->Set(context, "ambient", frame.ambient);
  surface_->Set(context, "culls_back_faces", frame.culls_back_faces ? 1 : 0);
}

void SurfacePainter::EndFrame() {
  meshes_.EndFrame();
  masks_.EndFrame();
}

void SurfacePainter::SetItem(gl::Context& context, const DrawItem& item, const GpuMesh& mesh,
                             const SurfacePass& pass) {
  gl::Program& program = item.glows ? *glow_ : *surface_;
  const DMat4 world_from_mesh = Matrix(item.world_from_mesh);
  program.Set(context, "clip_from_mesh", Mat4(pass.clip_from_world * world_from_mesh));
  program.Set(context, "world_from_mesh", Mat4(world_from_mesh));
  program.Set(context, "world_from_mesh_normal", NormalMatrix(item.world_from_mesh));
  program.Set(context, "depth_scale", item.depth_scale);
  program.Set(context, "has_face_normals", mesh.has_face_normals ? 1 : 0);
  if (item.glows) {
    program.Set(context, "radiance", item.color);
    program.Set(context, "two_sided", item.two_sided ? 1 : 0);
    return;
  }
  program.Set(context, "first_light", pass.first_light);
  program.Set(context, "end_light", pass.end_light);
  program.Set(context, "adds_ambient", pass.adds_ambient ? 1 : 0);
  program.Set(context, "color", item.color);
  program.Set(context, "has_vertex_normals", mesh.has_normals ? 1 : 0);
  program.Set(context, "alpha_cutoff", item.alpha_cutoff);
  program.Set(context, "has_mask", item.alpha_mask != nullptr ? 1 : 0);
  program.Set(context, "receives", item.receives ? 1 : 0);
  program.Set(context, "first_candidate", item.first_candidate);
  program.Set(context, "end_candidate", item.end_candidate);
}

absl::Status SurfacePainter::Draw(gl::Context& context, const DrawItem& item,
                                  const SurfacePass& pass) {
  auto mesh = meshes_.Find(*item.mesh, [&](const Mesh& m) { return GpuMesh::Create(context, m); });
  if (!mesh.ok()) return mesh.status();
  SetItem(context, item, **mesh, pass);
  if (item.alpha_mask != nullptr) {
    auto mask = masks_.Find(*item.alpha_mask,
                            [&](const AlphaMask& m) { return CreateMaskTexture(context, m); });
    if (!mask.ok()) return mask.status();
    (*mask)->Bind(context, kMaskUnit);
  }
  (*mesh)->face_normals.BindStorage(context, kFaceNormalsBinding);
  gl::Draw(context, {.program = item.glows ? *glow_ : *surface_,
                     .vertices = (*mesh)->vertices,
                     .target = pass.target,
                     .count = (*mesh)->index_count,
                     .depth_test = pass.depth_test,
                     .writes_depth = pass.depth_test != gl::DepthTest::kEqual,
                     .combine = pass.combine,
                     .stencil = pass.stencil});
  return absl::OkStatus();
}

}  // namespace penumbra
