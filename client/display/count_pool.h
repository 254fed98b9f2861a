// The counts of all artifacts of a picture in one GPU buffer.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "absl/status/status.h"
#include "client/display/draw_list.h"
#include "render/artifact/artifact.h"
#include "render/gl/buffer.h"
#include "render/gl/context.h"

namespace penumbra {

class CountPool {
 public:
  // Brings the counts of `list` to where its receivers expect them; uploads those that are not yet
  // there.
  //
  // Errors  kResourceExhausted: more texels than one storage block holds, or no GPU memory
  absl::Status Update(gl::Context& context, const DrawList& list);

  const gl::Buffer& buffer() const { return buffer_; }
  int64_t upload_count() const { return upload_count_; }
  void Clear();

 private:
  struct Slot {
    uint32_t first_texel = 0;
    std::shared_ptr<const Artifact> artifact;  // held, so that its address stays its own
  };

  gl::Buffer buffer_;
  std::vector<Slot> slots_;
  int64_t upload_count_ = 0;
};

}  // namespace penumbra
