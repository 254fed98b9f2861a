// The words of all artifacts of a picture that are not of a receiver, on the GPU.
#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "client/display/draw_list.h"
#include "client/display/shadow_words.h"
#include "render/artifact/artifact.h"
#include "render/gl/buffer.h"
#include "render/gl/context.h"
#include "render/scene/camera.h"

namespace penumbra {

class WordPool {
 public:
  // Artifacts with their lights.
  using Chosen = std::vector<std::pair<uint32_t, std::shared_ptr<const Artifact>>>;

  // What `list` has of any surface, for a shader: of each light the last layered attenuation map,
  // the last shadow-width map, and the last picture that is `camera`'s.
  static Chosen Choose(const DrawList& list, const Camera& camera);

  // Uploads those, unless it is what was uploaded last.
  //
  // order   all lights, in the order in which they are drawn; those with candidates are in theirs
  // Errors  kResourceExhausted: more than one storage block holds, or no GPU memory
  absl::Status Update(gl::Context& context, const DrawList& list, const Camera& camera,
                      const std::vector<uint32_t>& order);

  // As shadow_words_glsl.h wants it, at the bindings of surface_glsl.h.
  void Bind(gl::Context& context) const;

  int64_t upload_count() const { return upload_count_; }
  void Clear();

 private:
  absl::Status Upload(gl::Context& context, ShadowWords words, std::vector<LightShadow> shadows);

  gl::Buffer shadows_, faces_, words_;
  std::vector<uint32_t> order_;
  Chosen uploaded_;  // held, so that their addresses stay their own
  int64_t upload_count_ = 0;
};

}  // namespace penumbra
