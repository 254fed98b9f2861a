#include "deploy/scenes/glb_writer.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace penumbra::sample {
namespace {

using Json = nlohmann::ordered_json;

// glTF's numbers for what a view holds and how a component is written.
constexpr int kArrayBuffer = 34962;
constexpr int kElementArrayBuffer = 34963;
constexpr int kUnsignedShort = 5123;
constexpr int kFloat = 5126;

// Millionths, which print the same everywhere.
double Rounded(double x) { return std::round(x * 1e6) / 1e6 + 0.0; }

Json ToJson(DVec3 v) { return {Rounded(v.x), Rounded(v.y), Rounded(v.z)}; }

void AddLittleEndian(std::vector<uint8_t>& out, uint32_t value) {
  for (int shift = 0; shift < 32; shift += 8) out.push_back(static_cast<uint8_t>(value >> shift));
}

template <typename Container>
void AddChunk(std::vector<uint8_t>& glb, uint32_t type, const Container& payload, uint8_t fill) {
  const size_t padded = (payload.size() + 3) / 4 * 4;
  AddLittleEndian(glb, static_cast<uint32_t>(padded));
  AddLittleEndian(glb, type);
  glb.insert(glb.end(), payload.begin(), payload.end());
  glb.insert(glb.end(), padded - payload.size(), fill);
}

void UseExtension(Json& document, const char* name) {
  Json& used = document["extensionsUsed"];
  if (std::find(used.begin(), used.end(), name) == used.end()) used.push_back(name);
}

}  // namespace

GlbWriter::GlbWriter() {
  document_["asset"] = {{"version", "2.0"}, {"generator", "penumbra_make_sample"}};
  document_["scene"] = 0;
  document_["scenes"] = Json::array({{{"nodes", Json::array()}}});
}

int GlbWriter::AddView(const void* data, size_t size, int target) {
  binary_.resize((binary_.size() + 3) / 4 * 4);
  Json view = {{"buffer", 0}, {"byteOffset", binary_.size()}, {"byteLength", size}};
  if (target != 0) view["target"] = target;
  const auto* bytes = static_cast<const uint8_t*>(data);
  binary_.insert(binary_.end(), bytes, bytes + size);
  document_["bufferViews"].push_back(std::move(view));
  return static_cast<int>(document_["bufferViews"].size()) - 1;
}

int GlbWriter::AddAccessor(const void* data, size_t size, int target, int component_type,
                           size_t count, const char* type) {
  document_["accessors"].push_back({{"bufferView", AddView(data, size, target)},
                                    {"componentType", component_type},
                                    {"count", count},
                                    {"type", type}});
  return static_cast<int>(document_["accessors"].size()) - 1;
}

int GlbWriter::AddImage(std::span<const uint8_t> png) {
  const int view = AddView(png.data(), png.size(), 0);
  document_["images"].push_back({{"bufferView", view}, {"mimeType", "image/png"}});
  const int image = static_cast<int>(document_["images"].size()) - 1;
  document_["textures"].push_back({{"source", image}});
  return image;
}

int GlbWriter::AddMaterial(const Material& material) {
  Json pbr = {{"metallicFactor", 0.0}, {"roughnessFactor", 1.0}};
  Json json = {{"name", material.name}};
  if (material.alpha_image >= 0) {
    pbr["baseColorTexture"] = {{"index", material.alpha_image}};
    json["alphaMode"] = "MASK";
    json["alphaCutoff"] = 0.5;
  } else {
    pbr["baseColorFactor"] = {Rounded(material.color.x), Rounded(material.color.y),
                              Rounded(material.color.z), 1.0};
  }
  json["pbrMetallicRoughness"] = std::move(pbr);
  const double strength = std::max({material.emission.x, material.emission.y, material.emission.z});
  if (strength > 0.0) {
    json["emissiveFactor"] = ToJson(material.emission / strength);
    json["extensions"]["KHR_materials_emissive_strength"] = {
        {"emissiveStrength", Rounded(strength)}};
    UseExtension(document_, "KHR_materials_emissive_strength");
  }
  if (material.two_sided) json["doubleSided"] = true;
  document_["materials"].push_back(std::move(json));
  return static_cast<int>(document_["materials"].size()) - 1;
}

int GlbWriter::AddMesh(const std::string& name, const MeshGeometry& geometry, int material) {
  Aabb bounds;
  for (const Vec3 p : geometry.positions) bounds.Add(p);
  const auto vectors = [&](const auto& values, const char* type) {
    return AddAccessor(values.data(), sizeof(values[0]) * values.size(), kArrayBuffer, kFloat,
                       values.size(), type);
  };
  Json attributes;
  attributes["POSITION"] = vectors(geometry.positions, "VEC3");
  document_["accessors"].back()["min"] = {bounds.min.x, bounds.min.y, bounds.min.z};
  document_["accessors"].back()["max"] = {bounds.max.x, bounds.max.y, bounds.max.z};
  attributes["NORMAL"] = vectors(geometry.normals, "VEC3");
  if (!geometry.uvs.empty()) attributes["TEXCOORD_0"] = vectors(geometry.uvs, "VEC2");
  const std::vector<uint16_t> indices(geometry.indices.begin(), geometry.indices.end());
  const int index_accessor =
      AddAccessor(indices.data(), sizeof(indices[0]) * indices.size(), kElementArrayBuffer,
                  kUnsignedShort, indices.size(), "SCALAR");
  document_["meshes"].push_back({{"name", name},
                                 {"primitives", Json::array({{{"attributes", attributes},
                                                              {"indices", index_accessor},
                                                              {"material", material}}})}});
  return static_cast<int>(document_["meshes"].size()) - 1;
}

int GlbWriter::AddCamera(double fov_y) {
  document_["cameras"].push_back(
      {{"type", "perspective"},
       {"perspective", {{"yfov", Rounded(fov_y)}, {"aspectRatio", 1.5}, {"znear", 0.05}}}});
  return static_cast<int>(document_["cameras"].size()) - 1;
}

void GlbWriter::AddNode(const Node& node) {
  Json json = {{"name", node.name}};
  if (node.mesh >= 0) json["mesh"] = node.mesh;
  if (node.camera >= 0) json["camera"] = node.camera;
  if (node.translation != DVec3(0.0)) json["translation"] = ToJson(node.translation);
  if (node.turn != 0.0 || node.pitch != 0.0) {
    const double ct = std::cos(node.turn / 2), st = std::sin(node.turn / 2);
    const double cp = std::cos(node.pitch / 2), sp = std::sin(node.pitch / 2);
    json["rotation"] = {Rounded(ct * sp), Rounded(st * cp), Rounded(-st * sp), Rounded(ct * cp)};
  }
  if (node.scale != 1.0) json["scale"] = ToJson(DVec3(node.scale));
  document_["scenes"][0]["nodes"].push_back(document_["nodes"].size());
  document_["nodes"].push_back(std::move(json));
}

std::vector<uint8_t> GlbWriter::Bytes() const {
  Json document = document_;
  document["buffers"] = Json::array({{{"byteLength", (binary_.size() + 3) / 4 * 4}}});
  std::vector<uint8_t> chunks;
  AddChunk(chunks, 0x4e4f534a, document.dump(), ' ');
  AddChunk(chunks, 0x004e4942, binary_, 0);
  std::vector<uint8_t> glb = {'g', 'l', 'T', 'F'};
  AddLittleEndian(glb, 2);
  AddLittleEndian(glb, static_cast<uint32_t>(12 + chunks.size()));
  glb.insert(glb.end(), chunks.begin(), chunks.end());
  return glb;
}

}  // namespace penumbra::sample
