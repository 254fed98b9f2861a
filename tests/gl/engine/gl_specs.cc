#include "tests/gl/engine/gl_specs.h"

#include "tests/support/shapes.h"

namespace penumbra::testing {
namespace {

template <typename T>
void Append(const std::vector<T>& values, std::string& bits) {
  bits.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
}

struct BitsVisitor {
  std::string bits{};

  void operator()(const SoftShadowTexture& texture) {
    Append(texture.visibility.counts, bits);
    if (texture.radiance) Append(texture.radiance->texels, bits);
  }
  void operator()(const AttenuationLdi& ldi) {
    for (const LdiFace& face : ldi.faces) {
      Append(face.offsets, bits);
      Append(face.depths, bits);
      Append(face.counts, bits);
    }
  }
  void operator()(const ShadowWidthMap& map) {
    for (const ShadowWidthFace& face : map.faces) {
      Layer(face.near);
      if (face.far) Layer(*face.far);
    }
  }
  void operator()(const ShadowVolumeMesh& mesh) {
    for (const auto& volume : mesh.volumes) {
      for (const VolumeFace& face : volume->faces) Append(face.map.depths, bits);
      Append(volume->vertices, bits);
      Append(volume->indices, bits);
    }
  }
  void operator()(const ViewShadow& view) { Append(view.visibility.counts, bits); }

 private:
  void Layer(const ShadowWidthLayer& layer) {
    Append(layer.depths, bits);
    Append(layer.widths, bits);
  }
};

Instance Ball(float x, int around) {
  return {.id = "ball",
          .mesh = MeshOf(BallGeometry(around, around / 2)),
          .world_from_mesh = Placed(Vec3(x, 1.2f, 0.1f), 0.5f)};
}

}  // namespace

std::vector<GlSpec> GlSpecs(uint32_t resolution, uint32_t samples) {
  const auto texture = [&](VisibilityMethod method, Shading shading) {
    return ArtifactSpec{
        .params =
            SoftTextureParams{
                .samples = samples, .radiance = true, .method = method, .shading = shading},
        .light_id = "light",
        .receiver_id = "receiver"};
  };
  const auto layers = [&](DepthMethod source) {
    return ArtifactSpec{.params =
                            LayeredAttenuationParams{
                                .samples = samples, .resolution = resolution, .source = source},
                        .light_id = "light"};
  };
  const auto widths = [&](DistanceMethod distance, DepthMethod source) {
    return ArtifactSpec{
        .params =
            ShadowWidthParams{.resolution = resolution, .distance = distance, .source = source},
        .light_id = "light"};
  };
  const auto volumes = [&](DepthMethod source) {
    return ArtifactSpec{.params = ShadowVolumeParams{.resolution = resolution, .source = source},
                        .light_id = "light"};
  };
  return {{"soft_texture", texture(VisibilityMethod::kGl, Shading::kSampleSum),
           texture(VisibilityMethod::kAuto, Shading::kSampleSum)},
          {"layered_attenuation", layers(DepthMethod::kGl), layers(DepthMethod::kAuto)},
          {"shadow_width", widths(DistanceMethod::kExact, DepthMethod::kGl),
           widths(DistanceMethod::kExact, DepthMethod::kAuto)},
          {"shadow_width in steps", widths(DistanceMethod::kGlSix, DepthMethod::kAuto),
           widths(DistanceMethod::kGlSix, DepthMethod::kAuto)},
          {"shadow_volume", volumes(DepthMethod::kGl), volumes(DepthMethod::kAuto)}};
}

SceneDelta BallOverFloor(uint32_t texels, int around) {
  return {.upsert_instances = {Ball(0, around),
                               {.id = "box",
                                .mesh = MeshOf(UnitBoxGeometry()),
                                .world_from_mesh = Placed(Vec3(0.9f, 0.4f, -0.8f), 0.3f)},
                               {.id = "floor",
                                .mesh = MeshOf(UnitSquareGeometry()),
                                .world_from_mesh = Placed(Vec3(0), 2.0f)}},
          .upsert_lights = {{"light", RectangleLight{.corner = Vec3(-0.5f, 4, 0.5f),
                                                     .edge_u = Vec3(1, 0, 0),
                                                     .edge_v = Vec3(0, 0, -1)}}},
          .upsert_receivers = {FloorReceiver("receiver", 4, texels)}};
}

SceneDelta BallAt(float x, int around) { return {.upsert_instances = {Ball(x, around)}}; }

std::string BitsOf(const Artifact& artifact) {
  BitsVisitor visitor;
  std::visit(visitor, artifact.payload);
  return visitor.bits;
}

}  // namespace penumbra::testing
