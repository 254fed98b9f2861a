// What shadows need to know of an OBJ file's materials.
#pragma once

#include <filesystem>
#include <istream>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "client/import/image.h"
#include "client/import/warnings.h"
#include "render/math/vec.h"
#include "render/scene/alpha_mask.h"
#include "tiny_obj_loader.h"

namespace penumbra::obj {

struct Material {
  Vec3 color{0.8f};
  Vec3 emission{0.0f};
  bool casts = true;
  std::shared_ptr<const AlphaMask> mask;
};

// Opens the material libraries that lie in `folder` or below it, for tinyobjloader.
class LibraryReader : public tinyobj::MaterialReader {
 public:
  LibraryReader(std::filesystem::path folder, Warnings& warnings)
      : folder_(std::move(folder)), warnings_(warnings) {}

  bool operator()(const std::string& library, std::vector<tinyobj::material_t>* materials,
                  std::map<std::string, int>* indices, std::string* warning,
                  std::string* error) override;

 private:
  std::filesystem::path folder_;
  Warnings& warnings_;
};

// Textures that cannot be read count as white and opaque, with a warning.
Material ReadMaterial(const tinyobj::material_t& source, const std::filesystem::path& folder,
                      const SceneLimits& limits, Warnings& warnings);

}  // namespace penumbra::obj
