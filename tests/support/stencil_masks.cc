#include "tests/support/stencil_masks.h"

#include <cstdio>
#include <cstdlib>
#include <utility>

namespace penumbra::testing {
namespace {

// Surfaces without looks: depth is all that counts.
constexpr char kVertexGlsl[] = R"glsl(
layout(location = 0) in vec3 position_mesh;
uniform mat4 clip_from_mesh;
void main() { gl_Position = clip_from_mesh * vec4(position_mesh, 1.0); }
)glsl";
constexpr char kFragmentGlsl[] = R"glsl(
layout(location = 0) out vec4 pixel;
void main() { pixel = vec4(0.0, 0.0, 0.0, 1.0); }
)glsl";

void OrDie(const absl::Status& status) {
  if (status.ok()) return;
  std::fprintf(stderr, "stencil masks: %s\n", status.ToString().c_str());
  std::exit(1);
}

template <typename T>
T OrDie(absl::StatusOr<T> value) {
  OrDie(value.status());
  return *std::move(value);
}

// Reversed, and without an end (render/gl/draw.h).
DMat4 WithReversedDepth(DMat4 clip_from_world, double near) {
  for (int column = 0; column < 4; ++column) clip_from_world[column][2] = 0;
  clip_from_world[3][2] = near;
  return clip_from_world;
}

}  // namespace

StencilMasks::StencilMasks(gl::Context& context)
    : context_(context),
      painter_({.vertex = kVertexGlsl, .fragment = kFragmentGlsl}),
      sheet_(OrDie(CoverSheet::Create(context))) {
  OrDie(painter_.Bind(context));
}

std::vector<uint8_t> StencilMasks::MaskOf(const Scene& scene,
                                          const std::shared_ptr<const Artifact>& artifact,
                                          const EyeImage& eye) {
  const int width = static_cast<int>(eye.width), height = static_cast<int>(eye.height);
  if (!target_ || target_->options().width != width || target_->options().height != height) {
    target_ = OrDie(
        gl::Framebuffer::Create(context_, {.width = width, .height = height, .has_stencil = true}));
  }
  const DMat4 clip_from_world = WithReversedDepth(eye.clip_from_world, eye.near);
  const DrawList list = BuildDrawList(scene, std::span(&artifact, 1), /*draws_lights=*/false);
  OrDie(volumes_.Update(context_, list, Camera{}));
  OrDie(volumes_.Aim(context_, clip_from_world, 1));
  painter_.SetFrame(context_, Camera{}, {});
  target_->Clear(context_, Vec4(0));
  for (const DrawItem& item : list.items) {
    OrDie(painter_.Draw(context_, item, {.clip_from_world = clip_from_world, .target = *target_}));
  }
  painter_.EndFrame();
  for (const uint32_t light : volumes_.lights()) {
    volumes_.Mark(context_, *target_, DMat4(1.0), light, 0);
    sheet_.Draw(context_, *target_, Vec4(1), {.stencil = gl::Stencil::kWhereIsSet});
  }
  const std::vector<Vec4> pixels = OrDie(target_->ReadPixels(context_));
  std::vector<uint8_t> mask;
  mask.reserve(pixels.size());
  for (const Vec4& pixel : pixels) mask.push_back(pixel.x > 0.5f);
  return mask;
}

std::shared_ptr<const Artifact> ArtifactOf(ShadowVolumeMesh mesh) {
  return std::make_shared<Artifact>(
      Artifact{.header = {.light_id = "light", .is_final = true}, .payload = std::move(mesh)});
}

std::shared_ptr<const Scene> WithLight(const Scene& scene, AreaLight light) {
  light.id = "light";
  SceneDelta delta;
  delta.upsert_lights = {std::move(light)};
  return OrDie(scene.Apply(delta));
}

}  // namespace penumbra::testing
