#include "tests/bench/display_rows.h"

#include <array>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/display/thin_renderer.h"
#include "render/gl/context.h"
#include "render/scene/camera.h"

namespace penumbra::bench {
namespace {

constexpr char kShadowMapGlsl[] = R"glsl(
bool HasLayers(int light) { return light_shadows[light].layers.y > 0u; }

float LayerVisibility(int light, vec3 point, vec3 n) {
  uvec4 layers = light_shadows[light].layers;
  for (uint i = layers.x; i < layers.x + layers.y; ++i) {
    LightFace face = light_faces[i];
    vec3 way = point - face.origin.xyz;
    vec3 q = vec3(dot(way, face.s.xyz), dot(way, face.t.xyz), dot(way, face.n.xyz));
    if (!(q.z > 0.0)) continue;
    ivec2 place = ivec2(floor((q.xy / q.z - face.window.xy) * face.window.zw));
    ivec2 size = ivec2(face.image.xy);
    if (any(lessThan(place, ivec2(0))) || any(greaterThanEqual(place, size))) continue;
    float depth = uintBitsToFloat(words[face.image.w + uint(place.y * size.x + place.x)]);
    return q.z <= depth * 1.01 ? 1.0 : 0.0;
  }
  return 1.0;
}

bool HasWidths(int light) { return false; }
float WidthVisibility(int light, vec3 point, vec3 n) { return 1.0; }
bool FindInPicture(int light, vec3 at_center, vec3 inside, out float value) { return false; }
bool HasShares(int light) { return true; }
int DrawnLight(int place) { return place; }
)glsl";

// One layer a pixel: a depth map.
AttenuationLdi NearestLayers(const AttenuationLdi& ldi) {
  AttenuationLdi nearest = ldi;
  for (LdiFace& face : nearest.faces) {
    const LdiFace all = std::exchange(face, LdiFace{.view = face.view});
    face.offsets = {0};
    for (size_t p = 0; p + 1 < all.offsets.size(); ++p) {
      const bool has_some = all.offsets[p] < all.offsets[p + 1];
      face.depths.push_back(has_some ? all.depths[all.offsets[p]]
                                     : static_cast<float>(2 * all.view.far));
      face.counts.push_back(1);
      face.offsets.push_back(static_cast<uint32_t>(p + 1));
    }
  }
  return nearest;
}

std::array<std::shared_ptr<const Artifact>, 1> ArtifactOf(const Scene& scene, AttenuationLdi ldi) {
  auto artifact = std::make_shared<Artifact>();
  artifact->header.light_id = scene.lights().begin()->first;
  artifact->payload = std::move(ldi);
  return {std::move(artifact)};
}

}  // namespace

std::vector<Row> DisplayRows(const std::string& name, const Scene& scene, const AttenuationLdi& ldi,
                             const BenchOptions& options) {
  const auto context = OrDie(gl::Context::Create());
  const auto by_layers = OrDie(ThinRenderer::Create(*context));
  const auto by_shadow_map = OrDie(ThinRenderer::Create(
      *context,
      SurfaceProgram(absl::StrCat(ShadowWordBlocksGlsl(kShadowWordBindings), kShadowMapGlsl))));
  const auto layers = ArtifactOf(scene, ldi), nearest = ArtifactOf(scene, NearestLayers(ldi));
  const Camera camera = FrameScene(scene.Bounds(), 1.0f);
  const RenderOptions render{.width = 512, .height = 512, .samples_per_side = 1};
  const Duel duel = Interleave(
      0.2 * options.min_seconds,
      [&] { (void)OrDie(by_layers->Render(*context, scene, layers, camera, render)); },
      [&] { (void)OrDie(by_shadow_map->Render(*context, scene, nearest, camera, render)); });
  return {{name + ".display.frame", duel.OursMs(), "ms"},
          {name + ".display.overhead_vs_shadow_map", duel.OursMs() / duel.PeersMs(), "x"}};
}

}  // namespace penumbra::bench
