#include "client/cli/bake_files.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/cli/output_files.h"
#include "client/cli/volume_files.h"
#include "client/cli/width_map_files.h"
#include "client/display/deep_exr.h"
#include "client/display/image_io.h"
#include "client/display/tone.h"

namespace penumbra {
namespace {

// The channels of the EXR file, each with its own memory.
struct BakePlanes {
  std::vector<float> red, green, blue, count, inside;
};

BakePlanes PlanesOf(const RadianceTexture& radiance, const ShadowTexels& texels) {
  const VisibilityMap& map = texels.visibility;
  BakePlanes planes;
  for (const Vec3 texel : radiance.texels) {
    planes.red.push_back(texel.x);
    planes.green.push_back(texel.y);
    planes.blue.push_back(texel.z);
  }
  planes.count.assign(map.counts.begin(), map.counts.end());
  planes.inside.assign(map.counts.size(), 1.0f);
  for (size_t k = 0; texels.coverage && k < planes.inside.size(); ++k) {
    if (!texels.coverage->At(k)) planes.inside[k] = 0.0f;
  }
  return planes;
}

// What the screen shows, with the background where `coverage` has no surface; null: all is shown.
Picture ToPicture(const RadianceTexture& radiance, const CoverageMask* coverage) {
  Picture picture{.width = static_cast<int>(radiance.width),
                  .height = static_cast<int>(radiance.height),
                  .pixels = {}};
  picture.pixels.reserve(radiance.texels.size());
  for (size_t k = 0; k < radiance.texels.size(); ++k) {
    const bool is_covered = coverage == nullptr || coverage->At(k);
    picture.pixels.push_back(is_covered ? Vec4(radiance.texels[k], 1.0f) : Vec4(0.0f));
  }
  return picture;
}

// The fraction of the light that is visible, as a grey picture.
RadianceTexture VisibleShare(const VisibilityMap& map) {
  RadianceTexture share{.width = map.width, .height = map.height, .texels = {}};
  const auto most = static_cast<float>(std::max(map.sample_count, 1u));
  for (const uint16_t count : map.counts) share.texels.emplace_back(count / most);
  return share;
}

RadianceTexture PictureOf(const SoftShadowTexture& texture) {
  return texture.radiance ? *texture.radiance : ReflectedRadiance(texture);
}
RadianceTexture PictureOf(const ViewShadow& view) {
  return view.radiance ? *view.radiance : VisibleShare(view.visibility);
}

// Each pixel's nearest layer, black where there is none; faces one below the other.
RadianceTexture PictureOf(const AttenuationLdi& ldi) {
  RadianceTexture picture;
  for (const LdiFace& face : ldi.faces) {
    picture.width = std::max(picture.width, face.view.width);
    picture.height += face.view.height;
  }
  picture.texels.resize(size_t{picture.width} * picture.height);
  size_t row = 0;
  for (const LdiFace& face : ldi.faces) {
    for (uint32_t y = 0; y < face.view.height; ++y, ++row) {
      for (uint32_t x = 0; x < face.view.width; ++x) {
        const size_t p = size_t{y} * face.view.width + x;
        if (face.offsets[p] == face.offsets[p + 1]) continue;
        const float seen = face.counts[face.offsets[p]];
        picture.texels[row * picture.width + x] = Vec3(seen / ldi.sample_count);
      }
    }
  }
  return picture;
}

// With the brightest as white: a texture's unshadowed part, or what sees all of the light.
float ExposureForBrightest(const Picture& picture) {
  float brightest = 0.0f;
  for (const Vec4& pixel : picture.pixels) {
    brightest = std::max({brightest, pixel.x, pixel.y, pixel.z});
  }
  return brightest > 0.0f ? 1.0f / brightest : 1.0f;
}

float ExposureFor(const SoftShadowTexture&, const Picture& picture) {
  return ExposureForBrightest(picture);
}
float ExposureFor(const AttenuationLdi&, const Picture& picture) {
  return ExposureForBrightest(picture);
}
float ExposureFor(const ShadowWidthMap&, const Picture& picture) {
  return ExposureForBrightest(picture);
}
float ExposureFor(const ShadowVolumeMesh&, const Picture& picture) {
  return ExposureForBrightest(picture);
}
// As a view of the scene is exposed: next to a lamp all else would be black.
float ExposureFor(const ViewShadow& view, const Picture& picture) {
  return view.radiance ? SuggestExposure(picture) : ExposureForBrightest(picture);
}

// Texels outside of a receiver repeat those inside, so that filters mix in nothing foreign: they
// are shown like these.
const CoverageMask* ShownOf(const SoftShadowTexture&) { return nullptr; }
const CoverageMask* ShownOf(const AttenuationLdi&) { return nullptr; }
const CoverageMask* ShownOf(const ShadowWidthMap&) { return nullptr; }
const CoverageMask* ShownOf(const ShadowVolumeMesh&) { return nullptr; }
const CoverageMask* ShownOf(const ViewShadow& view) { return view.coverage.get(); }

absl::Status WriteNumbers(const std::filesystem::path& path, const ShadowTexels& texels,
                          const RadianceTexture& radiance) {
  const BakePlanes planes = PlanesOf(radiance, texels);
  const bool half = radiance.format == RadianceFormat::kHalf;
  const NamedPlane channels[] = {{"R", planes.red, half},
                                 {"G", planes.green, half},
                                 {"B", planes.blue, half},
                                 {"count", planes.count},
                                 {"inside", planes.inside}};
  return WriteExr(path, static_cast<int>(radiance.width), static_cast<int>(radiance.height),
                  channels);
}
absl::Status WriteNumbers(const std::filesystem::path& path, const AttenuationLdi& ldi,
                          const RadianceTexture&) {
  return WriteDeepExr(path, ldi);
}

constexpr const char* kBoundaryExtensions[] = {"glb", "ply", "obj"};

}  // namespace

std::vector<std::string> ExtensionsOf(const ArtifactPayload& payload) {
  std::vector<std::string> extensions = {"exr", "png", "json"};
  const auto* mesh = std::get_if<ShadowVolumeMesh>(&payload);
  if (mesh == nullptr) return extensions;
  if (!HasImages(*mesh)) extensions = {"json"};
  extensions.insert(extensions.end(), std::begin(kBoundaryExtensions),
                    std::end(kBoundaryExtensions));
  return extensions;
}

absl::StatusOr<std::vector<std::string>> WriteBake(const BakeRecord& record,
                                                   const std::filesystem::path& folder) {
  const ArtifactPayload& payload = record.artifact.payload;
  const auto path = [&](const std::string& extension) {
    return folder / absl::StrCat(record.name, ".", extension);
  };
  std::vector<std::string> files;
  for (const std::string& extension : ExtensionsOf(payload)) {
    files.push_back(absl::StrCat(record.name, ".", extension));
  }
  const RadianceTexture picture =
      std::visit([](const auto& kind) { return PictureOf(kind); }, payload);
  const Picture shown =
      std::visit([&](const auto& kind) { return ToPicture(picture, ShownOf(kind)); }, payload);
  const float exposure = record.exposure.value_or(
      std::visit([&](const auto& kind) { return ExposureFor(kind, shown); }, payload));
  absl::Status status;
  if (!shown.pixels.empty()) {
    status = std::visit([&](const auto& kind) { return WriteNumbers(path("exr"), kind, picture); },
                        payload);
    status.Update(
        WritePng(path("png"), shown.width, shown.height, ToSrgb(shown, {.exposure = exposure})));
  }
  if (const auto* mesh = std::get_if<ShadowVolumeMesh>(&payload)) {
    for (const char* extension : kBoundaryExtensions) {
      status.Update(WriteBoundary(path(extension), *mesh));
    }
  }
  if (status.ok()) status = WriteText(path("json"), BakeJson(record, exposure));
  if (!status.ok()) return status;
  return files;
}

}  // namespace penumbra
