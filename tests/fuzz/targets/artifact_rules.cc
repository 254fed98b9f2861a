#include "tests/fuzz/targets/artifact_rules.h"

#include <algorithm>
#include <span>

#include "tests/fuzz/kit/require.h"

namespace penumbra::fuzzing {
namespace {

bool AreInOrder(const LdiFace& face, uint32_t most) {
  const size_t pixels = size_t{face.view.width} * face.view.height;
  return face.offsets.size() == pixels + 1 && face.offsets.front() == 0 &&
         face.offsets.back() == face.depths.size() && face.counts.size() == face.depths.size() &&
         std::ranges::is_sorted(face.offsets) &&
         std::ranges::all_of(face.counts, [&](uint16_t count) { return count <= most; });
}

bool AreBelow(std::span<const uint32_t> indices, size_t end) {
  return std::ranges::all_of(indices, [&](uint32_t index) { return index < end; });
}

void RequireTexels(const ShadowTexels& texels, const SceneLimits& limits) {
  const VisibilityMap& map = texels.visibility;
  const size_t count = size_t{map.width} * map.height;
  Require(count > 0 && count <= limits.max_receiver_texels, "texels keep to their limit");
  Require(map.counts.size() == count, "a count a texel");
  Require(std::ranges::all_of(map.counts, [&](uint16_t c) { return c <= map.sample_count; }),
          "no texel sees more samples than there are");
  Require(!texels.radiance || texels.radiance->texels.size() == count, "a radiance a texel");
  Require(!texels.coverage || texels.coverage->texel_count() == count, "a bit a texel");
}

void RequirePayload(const SoftShadowTexture& texture, const SceneLimits& limits) {
  RequireTexels(texture, limits);
}
void RequirePayload(const ViewShadow& shadow, const SceneLimits& limits) {
  RequireTexels(shadow, limits);
}

void RequirePayload(const AttenuationLdi& ldi, const SceneLimits& limits) {
  Require(ldi.sample_count > 0, "counts are out of something");
  for (const LdiFace& face : ldi.faces) {
    Require(size_t{face.view.width} * face.view.height <= limits.max_receiver_texels,
            "pixels keep to their limit");
    Require(AreInOrder(face, ldi.sample_count),
            "layers are in order, and count no more samples than there are");
  }
}

void RequirePayload(const ShadowWidthMap& map, const SceneLimits& limits) {
  for (const ShadowWidthFace& face : map.faces) {
    const size_t texels = size_t{face.view.width} * face.view.height;
    Require(texels <= limits.max_receiver_texels, "texels keep to their limit");
    for (const ShadowWidthLayer& layer : {face.near, face.far.value_or(face.near)}) {
      Require(layer.depths.size() == texels && layer.widths.size() == texels,
              "a depth and a width a texel");
      Require(std::ranges::all_of(layer.widths, [](float w) { return w >= 0; }),
              "widths are numbers");
    }
  }
}

void RequirePayload(const ShadowVolumeMesh& mesh, const SceneLimits& limits) {
  Require(mesh.sample_count() <= limits.max_receiver_texels, "samples keep to their limit");
  for (const auto& volume : mesh.volumes) {
    Require(volume != nullptr, "no volume is null");
    const size_t end = volume->vertices.size();
    Require(AreBelow(volume->indices, end) && AreBelow(volume->caster_indices, end),
            "corners are vertices");
    Require(volume->indices.size() % 3 == 0 && volume->caster_indices.size() % 3 == 0,
            "three corners a triangle");
    Require(volume->weights.empty() || volume->weights.size() == volume->triangle_count(),
            "a weight a triangle");
    for (const VolumeFace& face : volume->faces) {
      Require(face.map.depths.size() == size_t{face.map.view.width} * face.map.view.height,
              "a depth a sample");
    }
  }
}

}  // namespace

void RequireRules(const Artifact& artifact, const SceneLimits& limits) {
  std::visit([&](const auto& payload) { RequirePayload(payload, limits); }, artifact.payload);
}

void RequireLookups(const Artifact& artifact) {
  constexpr float kFar = 1e9f;
  for (const Vec3& point :
       {Vec3(0), Vec3(0.3f, 0.1f, -0.2f), Vec3(1, 2, 4), Vec3(1.2f, 1.7f, 5), Vec3(0, -3, 0),
        Vec3(100, 0, -100), Vec3(kFar, -kFar, kFar), Vec3(1e-30f, 0, 1e-42f)}) {
    for (const Vec3& normal : {Vec3(0, 1, 0), Vec3(0, 0, -1), Vec3(0.6f, -0.8f, 0)}) {
      const float visible = Visibility(artifact, point, normal);
      Require(visible >= 0 && visible <= 1, "a visible fraction is one");
    }
    Covers(artifact, point);
  }
}

}  // namespace penumbra::fuzzing
