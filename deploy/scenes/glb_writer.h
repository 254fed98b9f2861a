// Puts meshes, materials and nodes together into a GLB file.
//
//   GlbWriter glb;
//   const int clay = glb.AddMaterial({.color = {0.6, 0.3, 0.2}});
//   glb.AddNode({.name = "vase", .mesh = glb.AddMesh(vase, clay), .translation = {0, 0.76, 0}});
//   WriteFile(glb.Bytes());
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "render/math/vec.h"
#include "render/scene/mesh.h"

namespace penumbra::sample {

struct Material {
  std::string name;
  DVec3 color{0.8};      // linear
  DVec3 emission{0.0};   // W·m⁻²·sr⁻¹; above 1 it needs KHR_materials_emissive_strength
  int alpha_image = -1;  // a picture that gives colour and cuts holes
  bool two_sided = false;
};

struct Node {
  std::string name;
  int mesh = -1;
  int camera = -1;
  DVec3 translation{0.0};
  double turn = 0.0;   // radians about +y
  double pitch = 0.0;  // radians about +x, before the turn
  double scale = 1.0;
};

class GlbWriter {
 public:
  GlbWriter();

  int AddImage(std::span<const uint8_t> png);
  int AddMaterial(const Material& material);
  int AddMesh(const std::string& name, const MeshGeometry& geometry, int material);
  int AddCamera(double fov_y);
  void AddNode(const Node& node);

  // The whole file: the same input, the same bytes.
  std::vector<uint8_t> Bytes() const;

 private:
  // Both return the new view's or accessor's number.
  int AddView(const void* data, size_t size, int target);
  int AddAccessor(const void* data, size_t size, int target, int component_type, size_t count,
                  const char* type);

  nlohmann::ordered_json document_;
  std::vector<uint8_t> binary_;
};

}  // namespace penumbra::sample
