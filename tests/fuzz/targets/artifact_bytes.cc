#include "tests/fuzz/targets/artifact_bytes.h"

#include <type_traits>
#include <utility>

namespace penumbra::fuzzing {
namespace {

// Values one after another, as they lie in memory.
class Bytes {
 public:
  template <typename T>
  void Put(const T& value) {
    static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>);
    text_.append(reinterpret_cast<const char*>(&value), sizeof(value));
  }
  void Put(const std::string& text) {
    Put(text.size());
    text_ += text;
  }
  template <int N, typename T>
  void Put(const glm::vec<N, T>& v) {
    for (int c = 0; c < N; ++c) Put(v[c]);
  }
  template <typename T>
  void PutAll(const T& values) {
    Put(std::size(values));
    for (const auto& value : values) Put(value);
  }
  void Put(const LightView& view) {
    for (const DVec3& v :
         {view.frame.origin, view.frame.axes.s, view.frame.axes.t, view.frame.axes.n, view.eye,
          DVec3(view.window.min, view.near), DVec3(view.window.max, view.far)}) {
      Put(v);
    }
    Put(view.from_infinity);
    Put(view.width);
    Put(view.height);
  }
  std::string Take() { return std::move(text_); }

 private:
  std::string text_;
};

void PutTexels(const ShadowTexels& texels, Bytes& out) {
  out.Put(texels.visibility.width);
  out.Put(texels.visibility.height);
  out.Put(texels.visibility.sample_count);
  out.PutAll(texels.visibility.counts);
  out.Put(texels.radiance.has_value());
  if (texels.radiance) out.PutAll(texels.radiance->texels);
  out.Put(texels.coverage != nullptr);
  if (texels.coverage) out.PutAll(texels.coverage->bytes());
}

void PutPayload(const SoftShadowTexture& texture, Bytes& out) { PutTexels(texture, out); }
void PutPayload(const ViewShadow& shadow, Bytes& out) { PutTexels(shadow, out); }

void PutPayload(const AttenuationLdi& ldi, Bytes& out) {
  out.Put(ldi.sample_count);
  out.Put(ldi.tolerance);
  for (const LdiFace& face : ldi.faces) {
    out.Put(face.view);
    out.PutAll(face.offsets);
    out.PutAll(face.depths);
    out.PutAll(face.counts);
  }
}

void PutPayload(const ShadowWidthMap& map, Bytes& out) {
  out.Put(map.c_scale.value_or(-1));
  out.Put(map.c_bias);
  for (const ShadowWidthFace& face : map.faces) {
    out.Put(face.view);
    for (const ShadowWidthLayer& layer : {face.near, face.far.value_or(ShadowWidthLayer{})}) {
      out.PutAll(layer.depths);
      out.PutAll(layer.widths);
    }
  }
}

void PutPayload(const ShadowVolumeMesh& mesh, Bytes& out) {
  for (const auto& volume : mesh.volumes) {
    out.Put(volume->instance_id);
    out.Put(volume->kind);
    for (const VolumeFace& face : volume->faces) {
      out.Put(face.map.view);
      out.PutAll(face.map.depths);
    }
    out.PutAll(volume->vertices);
    out.PutAll(volume->indices);
    out.PutAll(volume->weights);
    out.PutAll(volume->caster_indices);
  }
}

}  // namespace

std::string BytesOfArtifact(const Artifact& artifact) {
  Bytes out;
  const ArtifactHeader& header = artifact.header;
  for (const std::string* text :
       {&header.scene_id, &header.technique, &header.light_id, &header.receiver_id}) {
    out.Put(*text);
  }
  out.Put(header.revision);
  out.Put(header.pass);
  for (const LightSample& sample : header.light_samples) {
    out.Put(sample.point);
    out.Put(sample.at_infinity);
    out.Put(sample.weight);
  }
  std::visit([&](const auto& payload) { PutPayload(payload, out); }, artifact.payload);
  return out.Take();
}

}  // namespace penumbra::fuzzing
