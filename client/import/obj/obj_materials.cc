#include "client/import/obj/obj_materials.h"

#include <algorithm>
#include <optional>
#include <sstream>

#include "absl/strings/str_cat.h"
#include "client/import/source_file.h"

namespace penumbra::obj {
namespace {

// Dissolved surfaces are there or not: this is where the line is drawn.
constexpr float kDissolveCutoff = 0.5f;

Vec3 ToVec3(const tinyobj::real_t* v) { return {v[0], v[1], v[2]}; }

absl::StatusOr<Image> ReadTexture(const std::filesystem::path& folder, std::string name,
                                  const std::string& path, const SceneLimits& limits) {
  std::replace(name.begin(), name.end(), '\\', '/');
  absl::StatusOr<std::filesystem::path> file = ResolveBelow(folder, name, path);
  if (!file.ok()) return file.status();
  absl::StatusOr<std::vector<std::byte>> bytes = ReadFile(*file);
  if (!bytes.ok()) return bytes.status();
  return DecodeImage(*bytes, path, limits);
}

// Grey maps hold the opacity as brightness, others in their alpha channel.
std::vector<uint8_t> MaskOf(const Image& image) {
  Opacity opacity = OpacityOf(image);
  if (opacity.clear > 0) return std::move(opacity.alpha);
  for (size_t i = 0; i < opacity.alpha.size(); ++i) opacity.alpha[i] = image.rgba[4 * i];
  return std::move(opacity.alpha);
}

}  // namespace

bool LibraryReader::operator()(const std::string& library,
                               std::vector<tinyobj::material_t>* materials,
                               std::map<std::string, int>* indices, std::string* warning,
                               std::string* error) {
  const absl::StatusOr<std::filesystem::path> path = ResolveBelow(folder_, library, "mtllib");
  absl::StatusOr<std::vector<std::byte>> bytes = path.ok() ? ReadFile(*path) : path.status();
  if (!bytes.ok()) {
    warnings_.Add(absl::StrCat(bytes.status().message(), "; its materials are left out"));
    return true;
  }
  std::istringstream stream{std::string(AsText(*bytes))};
  tinyobj::LoadMtl(indices, materials, &stream, warning, error);
  return true;
}

Material ReadMaterial(const tinyobj::material_t& source, const std::filesystem::path& folder,
                      const SceneLimits& limits, Warnings& warnings) {
  Material material{.color = ToVec3(source.diffuse), .emission = ToVec3(source.emission)};
  const Vec3 ambient = ToVec3(source.ambient);
  if (material.emission == Vec3(0.0f) && glm::any(glm::greaterThan(ambient, Vec3(1.0f)))) {
    material.emission = ambient;
  }
  if (!IsFinite(material.emission) || glm::any(glm::lessThan(material.emission, Vec3(0.0f)))) {
    material.emission = Vec3(0.0f);
  }
  const std::string path = absl::StrCat("newmtl ", Quoted(source.name));
  if (!source.diffuse_texname.empty()) {
    const auto image = ReadTexture(folder, source.diffuse_texname, path + ".map_Kd", limits);
    // Exporters leave Kd black beside a texture.
    if (image.ok()) {
      material.color =
          MeanLinearColor(*image) * (material.color == Vec3(0.0f) ? Vec3(1.0f) : material.color);
    } else {
      warnings.Add(absl::StrCat(image.status().message(), "; ignored"));
    }
  }
  material.color =
      IsFinite(material.color) ? glm::clamp(material.color, Vec3(0.0f), Vec3(1.0f)) : Vec3(0.8f);
  if (!(source.dissolve >= kDissolveCutoff)) {
    material.casts = false;
    warnings.Add(absl::StrCat(path, ".d: below ", kDissolveCutoff, ", casts no shadow"));
  }
  if (!source.alpha_texname.empty()) {
    const auto image = ReadTexture(folder, source.alpha_texname, path + ".map_d", limits);
    if (!image.ok()) {
      warnings.Add(absl::StrCat(image.status().message(), "; ignored"));
      return material;
    }
    auto mask = AlphaMask::Create(image->width, image->height, MaskOf(*image), limits);
    if (mask.ok()) material.mask = *std::move(mask);
  }
  return material;
}

}  // namespace penumbra::obj
