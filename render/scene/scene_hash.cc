#include "render/scene/scene_hash.h"

#include <string>
#include <variant>

#include "render/scene/hashed_bytes.h"

namespace penumbra {
namespace {

void PutShape(HashedBytes& out, const RectangleLight& s) {
  for (const Vec3& v : {s.corner, s.edge_u, s.edge_v, s.radiance}) out.Put(v);
  out.Put(s.two_sided);
}
void PutShape(HashedBytes& out, const DiskLight& s) {
  for (const Vec3& v : {s.center, s.normal, s.radiance}) out.Put(v);
  out.Put(s.radius);
  out.Put(s.two_sided);
}
void PutShape(HashedBytes& out, const SphereLight& s) {
  for (const Vec3& v : {s.center, s.radiance}) out.Put(v);
  out.Put(s.radius);
}
void PutShape(HashedBytes& out, const PointLight& s) {
  for (const Vec3& v : {s.position, s.intensity}) out.Put(v);
}
void PutShape(HashedBytes& out, const SpotLight& s) {
  for (const Vec3& v : {s.position, s.direction, s.intensity}) out.Put(v);
  out.Put(s.inner_angle);
  out.Put(s.outer_angle);
}
void PutShape(HashedBytes& out, const DistantLight& s) {
  for (const Vec3& v : {s.to_light, s.irradiance}) out.Put(v);
  out.Put(s.angular_diameter);
}
void PutShape(HashedBytes& out, const Parallelogram& s) {
  for (const Vec3& v : {s.origin, s.edge_u, s.edge_v}) out.Put(v);
}
void PutShape(HashedBytes& out, const PlanarInstance& s) { out.Put(s.instance_id); }
void PutShape(HashedBytes& out, const Triangle& s) {
  for (const Vec3& v : {s.corner, s.edge_u, s.edge_v}) out.Put(v);
}
void PutShape(HashedBytes& out, const PlanarPolygon& s) {
  out.Put(static_cast<uint32_t>(s.vertices.size()));
  for (const Vec3& v : s.vertices) out.Put(v);
}
void PutShape(HashedBytes& out, const PlanarSurface& s) {
  out.Put(s.instance_id);
  out.Put(s.triangle);
}

void PutPlacedMesh(HashedBytes& out, const Instance& instance) {
  out.Put(uint32_t{'I'});
  out.Put(instance.id);
  out.Put(instance.mesh->id());
  for (int column = 0; column < 4; ++column) out.Put(instance.world_from_mesh[column]);
  out.Put(instance.casts);
  out.Put(instance.receives);
}

void PutMask(HashedBytes& out, const Instance& instance) {
  out.Put(instance.alpha_mask != nullptr);
  if (instance.alpha_mask) out.Put(instance.alpha_mask->id());
  out.Put(instance.alpha_cutoff);
}

}  // namespace

ContentHash HashOf(const Instance& instance) {
  HashedBytes out;
  PutPlacedMesh(out, instance);
  out.Put(instance.color);
  PutMask(out, instance);
  return out.Hash();
}

ContentHash HashOfSurfaces(const InstanceTable& instances) {
  HashedBytes out;
  for (const auto& [id, instance] : instances) {
    PutPlacedMesh(out, *instance);
    PutMask(out, *instance);
  }
  return out.Hash();
}

ContentHash HashOf(const AreaLight& light) {
  HashedBytes out;
  out.Put(uint32_t{'L'});
  out.Put(light.id);
  out.Put(static_cast<uint32_t>(light.shape.index()));
  std::visit([&out](const auto& shape) { PutShape(out, shape); }, light.shape);
  return out.Hash();
}

ContentHash HashOf(const Receiver& receiver) {
  HashedBytes out;
  out.Put(uint32_t{'R'});
  out.Put(receiver.id);
  out.Put(static_cast<uint32_t>(receiver.shape.index()));
  std::visit([&out](const auto& shape) { PutShape(out, shape); }, receiver.shape);
  out.Put(receiver.width);
  out.Put(receiver.height);
  out.Put(receiver.two_sided);
  out.Put(receiver.reflectance);
  out.Put(receiver.texels_per_metre);
  out.Put(receiver.max_auto_side);
  return out.Hash();
}

}  // namespace penumbra
