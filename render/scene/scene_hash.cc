#include "render/scene/scene_hash.h"

#include <span>
#include <string>
#include <variant>

namespace penumbra {
namespace {

// The bytes by which an object counts in a scene's hash. −0 is written as 0.
class Bytes {
 public:
  void Put(const std::string& text) {
    Put(static_cast<uint32_t>(text.size()));
    Append(text.data(), text.size());
  }
  void Put(const ContentHash& hash) { Append(hash.bytes.data(), hash.bytes.size()); }
  void Put(float x) {
    x += 0.0f;
    Append(&x, sizeof(x));
  }
  void Put(Vec3 v) {
    for (int c = 0; c < 3; ++c) Put(v[c]);
  }
  void Put(uint32_t x) { Append(&x, sizeof(x)); }
  void Put(bool x) { Put(uint32_t{x}); }

  ContentHash Hash() const { return Sha256(std::as_bytes(std::span(bytes_))); }

 private:
  void Append(const void* data, size_t size) {
    bytes_.append(static_cast<const char*>(data), size);
  }

  std::string bytes_;
};

void PutShape(Bytes& out, const RectangleLight& s) {
  for (const Vec3& v : {s.corner, s.edge_u, s.edge_v, s.radiance}) out.Put(v);
  out.Put(s.two_sided);
}
void PutShape(Bytes& out, const DiskLight& s) {
  for (const Vec3& v : {s.center, s.normal, s.radiance}) out.Put(v);
  out.Put(s.radius);
  out.Put(s.two_sided);
}
void PutShape(Bytes& out, const SphereLight& s) {
  for (const Vec3& v : {s.center, s.radiance}) out.Put(v);
  out.Put(s.radius);
}
void PutShape(Bytes& out, const PointLight& s) {
  for (const Vec3& v : {s.position, s.intensity}) out.Put(v);
}
void PutShape(Bytes& out, const SpotLight& s) {
  for (const Vec3& v : {s.position, s.direction, s.intensity}) out.Put(v);
  out.Put(s.inner_angle);
  out.Put(s.outer_angle);
}
void PutShape(Bytes& out, const DistantLight& s) {
  for (const Vec3& v : {s.to_light, s.irradiance}) out.Put(v);
  out.Put(s.angular_diameter);
}
void PutShape(Bytes& out, const Parallelogram& s) {
  for (const Vec3& v : {s.origin, s.edge_u, s.edge_v}) out.Put(v);
}
void PutShape(Bytes& out, const PlanarInstance& s) { out.Put(s.instance_id); }
void PutShape(Bytes& out, const Triangle& s) {
  for (const Vec3& v : {s.corner, s.edge_u, s.edge_v}) out.Put(v);
}
void PutShape(Bytes& out, const PlanarPolygon& s) {
  out.Put(static_cast<uint32_t>(s.vertices.size()));
  for (const Vec3& v : s.vertices) out.Put(v);
}
void PutShape(Bytes& out, const PlanarSurface& s) {
  out.Put(s.instance_id);
  out.Put(s.triangle);
}

}  // namespace

ContentHash HashOf(const Instance& instance) {
  Bytes out;
  out.Put(uint32_t{'I'});
  out.Put(instance.id);
  out.Put(instance.mesh->id());
  for (int column = 0; column < 4; ++column) out.Put(instance.world_from_mesh[column]);
  out.Put(instance.casts);
  out.Put(instance.receives);
  out.Put(instance.color);
  out.Put(instance.alpha_mask != nullptr);
  if (instance.alpha_mask) out.Put(instance.alpha_mask->id());
  out.Put(instance.alpha_cutoff);
  return out.Hash();
}

ContentHash HashOf(const AreaLight& light) {
  Bytes out;
  out.Put(uint32_t{'L'});
  out.Put(light.id);
  out.Put(static_cast<uint32_t>(light.shape.index()));
  std::visit([&out](const auto& shape) { PutShape(out, shape); }, light.shape);
  return out.Hash();
}

ContentHash HashOf(const Receiver& receiver) {
  Bytes out;
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
