#include "render/gl/texture.h"

#include "absl/strings/str_cat.h"
#include "render/gl/gl.h"

namespace penumbra::gl {
namespace {

struct FormatInfo {
  GLenum internal;
  GLenum layout;
  GLenum type;
  size_t bytes;
};

FormatInfo InfoOf(Format format) {
  switch (format) {
    case Format::kR8:
      return {GL_R8, GL_RED, GL_UNSIGNED_BYTE, 1};
    case Format::kR16Ui:
      return {GL_R16UI, GL_RED_INTEGER, GL_UNSIGNED_SHORT, 2};
    case Format::kR32F:
      return {GL_R32F, GL_RED, GL_FLOAT, 4};
    case Format::kRgba8:
      return {GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE, 4};
    case Format::kRgba16F:
      return {GL_RGBA16F, GL_RGBA, GL_HALF_FLOAT, 8};
    case Format::kRgba32F:
      return {GL_RGBA32F, GL_RGBA, GL_FLOAT, 16};
    case Format::kDepth32F:
      return {GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GL_FLOAT, 4};
    case Format::kDepth32FStencil8:
      return {GL_DEPTH32F_STENCIL8, GL_DEPTH_STENCIL, GL_FLOAT_32_UNSIGNED_INT_24_8_REV, 8};
    case Format::kR8Ui:
      return {GL_R8UI, GL_RED_INTEGER, GL_UNSIGNED_BYTE, 1};
    case Format::kRg32Ui:
      return {GL_RG32UI, GL_RG_INTEGER, GL_UNSIGNED_INT, 8};
  }
  return {};
}

void Delete(uint32_t name) { glDeleteTextures(1, &name); }

absl::Status CheckOptions(const Context& context, const TextureOptions& options) {
  const int max_side = context.info().max_texture_side;
  if (options.width < 1 || options.height < 1 || options.width > max_side ||
      options.height > max_side) {
    return absl::InvalidArgumentError(absl::StrCat("gl::Texture: found ", options.width, " × ",
                                                   options.height, ", need sides of 1 to ",
                                                   max_side));
  }
  if (options.samples < 1 || options.samples > context.info().max_samples) {
    return absl::InvalidArgumentError(absl::StrCat("gl::Texture: found ", options.samples,
                                                   " samples, need 1 to ",
                                                   context.info().max_samples));
  }
  return absl::OkStatus();
}

}  // namespace

size_t BytesPerTexel(Format format) { return InfoOf(format).bytes; }

absl::StatusOr<Texture> Texture::Create(Context& context, const TextureOptions& options) {
  if (absl::Status status = context.MakeCurrent(); !status.ok()) return status;
  if (absl::Status status = CheckOptions(context, options); !status.ok()) return status;
  const size_t texels = size_t{1} * options.width * options.height;
  auto memory =
      context.TakeMemory(texels * options.samples * InfoOf(options.format).bytes, "gl::Texture");
  if (!memory.ok()) return memory.status();
  const bool has_samples = options.samples > 1;
  const GLenum internal = InfoOf(options.format).internal;
  GLuint name = 0;
  glCreateTextures(has_samples ? GL_TEXTURE_2D_MULTISAMPLE : GL_TEXTURE_2D, 1, &name);
  Texture texture;
  texture.memory_ = *std::move(memory);
  texture.name_ = ObjectName(context, name, &Delete);
  texture.options_ = options;
  if (has_samples) {
    glTextureStorage2DMultisample(name, options.samples, internal, options.width, options.height,
                                  GL_TRUE);
  } else {
    glTextureStorage2D(name, 1, internal, options.width, options.height);
    glTextureParameteri(name, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTextureParameteri(name, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glTextureParameteri(name, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTextureParameteri(name, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  }
  if (absl::Status status = context.Check("gl::Texture"); !status.ok()) return status;
  return texture;
}

absl::Status Texture::Write(Context& context, std::span<const std::byte> texels) {
  if (absl::Status status = context.MakeCurrent(); !status.ok()) return status;
  const FormatInfo format = InfoOf(options_.format);
  const size_t needed = format.bytes * options_.width * options_.height;
  if (texels.size() != needed) {
    return absl::InvalidArgumentError(
        absl::StrCat("gl::Texture: found ", texels.size(), " bytes of texels, need ", needed));
  }
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTextureSubImage2D(name(), 0, 0, 0, options_.width, options_.height, format.layout, format.type,
                      texels.data());
  return context.Check("gl::Texture::Write");
}

void Texture::Bind(Context& context, uint32_t unit) const {
  if (context.MakeCurrent().ok()) glBindTextureUnit(unit, name());
}

}  // namespace penumbra::gl
