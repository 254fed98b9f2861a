#include "client/import/gltf/materials.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"

namespace penumbra::gltf {
namespace {

// Blended surfaces are there or not: this is where the line is drawn.
constexpr float kBlendCutoff = 0.5f;
// A surface that lets this much through is taken as clear glass, which casts no shadow.
constexpr double kClearTransmission = 0.5;

Vec3 ToVec3(const std::vector<double>& v) { return Vec3(DVec3(v[0], v[1], v[2])); }

std::vector<double> Numbers(const tinygltf::Value& array) {
  std::vector<double> numbers;
  for (size_t i = 0; i < array.ArrayLen(); ++i) {
    numbers.push_back(array.Get(static_cast<int>(i)).GetNumberAsDouble());
  }
  return numbers;
}

TextureCoordinates CoordinatesOf(const tinygltf::TextureInfo& info) {
  TextureCoordinates coordinates{.set = info.texCoord};
  const tinygltf::Value* transform = FindExtension(info.extensions, "KHR_texture_transform");
  if (transform == nullptr) return coordinates;
  if (transform->Has("offset")) {
    const auto offset = Numbers(transform->Get("offset"));
    coordinates.offset = Vec2(DVec2(offset[0], offset[1]));
  }
  if (transform->Has("scale")) {
    const auto scale = Numbers(transform->Get("scale"));
    coordinates.scale = Vec2(DVec2(scale[0], scale[1]));
  }
  coordinates.rotation = static_cast<float>(NumberOr(*transform, "rotation", 0.0));
  coordinates.set = static_cast<int>(NumberOr(*transform, "texCoord", coordinates.set));
  return coordinates;
}

}  // namespace

// Source  KHR_texture_transform: T · R · S
Vec2 TextureCoordinates::Apply(Vec2 uv) const {
  const Vec2 scaled = uv * scale;
  const float c = std::cos(rotation), s = std::sin(rotation);
  return Vec2(c * scaled.x + s * scaled.y, -s * scaled.x + c * scaled.y) + offset;
}

const Material& Materials::Get(int index) {
  const auto known = known_.find(index);
  if (known != known_.end()) return known->second;
  return known_.emplace(index, index < 0 ? Material{} : Read(index)).first->second;
}

Material Materials::Read(int index) {
  const tinygltf::Material& source = document_.model().materials[index];
  Material material;
  float alpha_factor = 1.0f;
  material.color = glm::clamp(BaseColor(index, alpha_factor), Vec3(0.0f), Vec3(1.0f));
  material.emission = Emission(index);
  material.two_sided = source.doubleSided;
  if (source.alphaMode == "MASK" || source.alphaMode == "BLEND") {
    ReadAlpha(index, alpha_factor, material);
  }
  const auto* transmission = FindExtension(source.extensions, "KHR_materials_transmission");
  if (transmission && NumberOr(*transmission, "transmissionFactor", 0.0) >= kClearTransmission) {
    material.casts = false;
    warnings_.Add(absl::StrCat("materials[", index, "]: clear glass, casts no shadow"));
  }
  return material;
}

Vec3 Materials::BaseColor(int index, float& alpha_factor) {
  const tinygltf::Material& source = document_.model().materials[index];
  const auto* glossy = FindExtension(source.extensions, "KHR_materials_pbrSpecularGlossiness");
  std::vector<double> factor = source.pbrMetallicRoughness.baseColorFactor;
  int texture = source.pbrMetallicRoughness.baseColorTexture.index;
  if (glossy != nullptr) {
    factor = glossy->Has("diffuseFactor") ? Numbers(glossy->Get("diffuseFactor"))
                                          : std::vector<double>{1, 1, 1, 1};
    texture = glossy->Has("diffuseTexture")
                  ? static_cast<int>(NumberOr(glossy->Get("diffuseTexture"), "index", -1))
                  : -1;
  }
  if (factor.size() != 4) factor = {1, 1, 1, 1};
  alpha_factor = std::clamp(static_cast<float>(factor[3]), 0.0f, 1.0f);
  return ToVec3(factor) * MeanColor(texture);
}

Vec3 Materials::Emission(int index) {
  const tinygltf::Material& source = document_.model().materials[index];
  if (source.emissiveFactor.size() != 3) return Vec3(0.0f);
  Vec3 emission = glm::max(ToVec3(source.emissiveFactor), Vec3(0.0f));
  if (emission == Vec3(0.0f)) return emission;
  const auto* strength = FindExtension(source.extensions, "KHR_materials_emissive_strength");
  if (strength) emission *= static_cast<float>(NumberOr(*strength, "emissiveStrength", 1.0));
  emission *= MeanColor(source.emissiveTexture.index);
  if (!IsFinite(emission)) {
    warnings_.Add(absl::StrCat("materials[", index, "].emissiveFactor: overflows, ignored"));
    return Vec3(0.0f);
  }
  return emission;
}

// The mask keeps the texture's own opacities, so the factor goes into the cutoff.
void Materials::ReadAlpha(int index, float factor, Material& material) {
  const tinygltf::Material& source = document_.model().materials[index];
  const bool blended = source.alphaMode == "BLEND";
  const std::string path = absl::StrCat("materials[", index, "]");
  const float cutoff = blended ? kBlendCutoff : static_cast<float>(source.alphaCutoff);
  if (blended) {
    warnings_.Add(absl::StrCat(path, ".alphaMode: BLEND, taken as MASK at ", kBlendCutoff));
  }
  if (factor < cutoff) {
    // A blended pane this clear is drawn and lets light through; a masked one is not there.
    material.casts = false;
    material.absent = !blended;
    return;
  }
  const int texture = source.pbrMetallicRoughness.baseColorTexture.index;
  const Image* image = TextureImage(texture);
  if (image == nullptr) return;
  Opacity opacity = OpacityOf(*image);
  if (opacity.clear == 0) return;
  auto mask =
      AlphaMask::Create(image->width, image->height, std::move(opacity.alpha), document_.limits());
  if (!mask.ok()) {
    warnings_.Add(absl::StrCat(path, ": mask ignored: ", mask.status().message()));
    return;
  }
  material.mask = *std::move(mask);
  material.cutoff = std::clamp(cutoff / factor, 0.0f, 1.0f);
  material.mask_uv = CoordinatesOf(source.pbrMetallicRoughness.baseColorTexture);
}

const Image* Materials::TextureImage(int texture) {
  if (texture < 0) return nullptr;
  const int source = document_.model().textures[texture].source;
  if (source < 0) {
    warnings_.Add(absl::StrCat("textures[", texture, "]: no image of a known kind, ignored"));
    return nullptr;
  }
  const auto known = images_.find(source);
  if (known != images_.end()) return known->second ? &*known->second : nullptr;
  std::optional<Image>& image = images_[source];
  absl::StatusOr<std::vector<std::byte>> file = document_.ImageFile(source);
  absl::StatusOr<Image> decoded =
      file.ok() ? DecodeImage(*file, absl::StrCat("images[", source, "]"), document_.limits())
                : file.status();
  if (decoded.ok()) {
    image = *std::move(decoded);
  } else {
    warnings_.Add(absl::StrCat(decoded.status().message(), "; ignored"));
  }
  return image ? &*image : nullptr;
}

Vec3 Materials::MeanColor(int texture) {
  const Image* image = TextureImage(texture);
  return image == nullptr ? Vec3(1.0f) : MeanLinearColor(*image);
}

}  // namespace penumbra::gltf
