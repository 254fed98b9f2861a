// Shadow volumes in a picture: the stencil says which samples are in shadow.
//
//   VolumeShadows volumes;
//   status = volumes.Update(context, list, camera);         // uploads what is new
//   status = volumes.Aim(context, clip_from_world, passes);  // closes them where the eye cuts them
//   for (const uint32_t light : volumes.lights()) {
//     volumes.Mark(context, target, tile_from_clip, light, pass);
//     … draw with gl::Stencil::kWhereIsSet …
//
// Source  McCool 2000, §6; several passes §8.3
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "client/display/draw_list.h"
#include "render/artifact/volume_cap.h"
#include "render/gl/buffer.h"
#include "render/gl/context.h"
#include "render/gl/draw.h"
#include "render/gl/program.h"
#include "render/scene/camera.h"

namespace penumbra {

class VolumeShadows {
 public:
  // Takes of each light of which `list` has nothing else for `camera` the last shadow volume mesh.
  //
  // Errors  kResourceExhausted: GPU memory; kInternal: the driver does not take the shaders
  absl::Status Update(gl::Context& context, const DrawList& list, const Camera& camera);

  // Lights with volumes, by their index in the list.
  const std::vector<uint32_t>& lights() const { return lights_; }
  // All lights of the list: first those without volumes, then lights().
  const std::vector<uint32_t>& order() const { return order_; }

  // Turns the volumes a little for each of the passes and finds what closes them.
  //
  // clip_from_world  ClipFromWorld of a camera
  // Errors           kResourceExhausted: GPU memory
  absl::Status Aim(gl::Context& context, const DMat4& clip_from_world, int passes);

  // Sets the target's stencil where what is drawn so far is in the shadow of the light, as pass
  // `pass` has it, and clears it elsewhere.
  //
  // tile_from_clip  of the picture's clip space, what of it the target shows
  void Mark(gl::Context& context, gl::Framebuffer& target, const DMat4& tile_from_clip,
            uint32_t light, int pass);

  int64_t upload_count() const { return upload_count_; }
  void Clear();

 private:
  // Triangles of clip space that close a mesh's volumes.
  struct Caps {
    DMat4 clip_from_world{1.0};
    gl::Buffer buffer;
    gl::VertexArray corners;
    int corner_count = 0;
    uint8_t first_value = 0;  // of the stencil
  };
  struct Volumes {
    std::shared_ptr<const Artifact> artifact;  // held, so that what refers to it stays
    bool counts = false;                       // and does not invert a bit
    gl::Buffer vertex_buffer, index_buffer;
    gl::VertexArray vertices;
    int index_count = 0;
    std::vector<VolumeCapper> cappers;
    std::vector<Caps> caps;  // one a pass
  };

  static absl::StatusOr<Volumes> Upload(gl::Context& context,
                                        std::shared_ptr<const Artifact> artifact);
  static absl::StatusOr<Caps> CapsFor(gl::Context& context, const Volumes& volumes,
                                      const DMat4& clip_from_world, double near);

  std::optional<gl::Program> program_;
  std::vector<uint32_t> lights_, order_;
  std::map<const Artifact*, Volumes> uploaded_;
  std::map<uint32_t, const Artifact*> of_light_;
  int64_t upload_count_ = 0;
};

// World space to world space: how the volumes of a mesh are moved in one of several passes. Turned
// about the light, or moved across its direction, by up to half a sample either way, such that the
// passes of each direction are evenly apart (n rooks); and a little away from the light.
//
// Source  McCool 2000, §8.3; departs: a turn moves all views of a light alike, and so opens no
//         cracks between them, as shears would
DMat4 VolumeTurn(const ShadowVolumeMesh& mesh, int pass, int passes);

}  // namespace penumbra
