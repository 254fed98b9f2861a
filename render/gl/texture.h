// A two-dimensional texture, with one sample a texel or several.
//
//   auto target = gl::Texture::Create(context, {.width = 512, .height = 512,
//                                               .format = gl::Format::kRgba32F, .samples = 4});
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "absl/status/statusor.h"
#include "render/gl/context.h"

namespace penumbra::gl {

enum class Format {
  kR8,
  kR16Ui,
  kR32F,
  kRgba8,
  kRgba16F,
  kRgba32F,
  kDepth32F,
  kDepth32FStencil8,
  kR8Ui,
  kRg32Ui
};

size_t BytesPerTexel(Format format);

struct TextureOptions {
  int width = 0;
  int height = 0;
  Format format = Format::kRgba8;
  int samples = 1;  // above 1: multisampled, for drawing into only
};

// Filters nearest and clamps to its edge.
class Texture {
 public:
  // Errors  kInvalidArgument: a side is not in [1, max_texture_side], or too many samples; those of
  //         Context::TakeMemory and Context::Check
  static absl::StatusOr<Texture> Create(Context& context, const TextureOptions& options);

  const TextureOptions& options() const { return options_; }
  uint32_t name() const { return name_.get(); }

  // Replaces all texels, row 0 first, rows without padding. Errors  kInvalidArgument: wrong length
  absl::Status Write(Context& context, std::span<const std::byte> texels);
  void Bind(Context& context, uint32_t unit) const;

 private:
  MemoryBudget::Lease memory_;
  ObjectName name_;
  TextureOptions options_;
};

}  // namespace penumbra::gl
