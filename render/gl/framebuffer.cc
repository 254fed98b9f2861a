#include "render/gl/framebuffer.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "render/gl/gl.h"

namespace penumbra::gl {
namespace {

void Delete(uint32_t name) { glDeleteFramebuffers(1, &name); }

GLenum DepthAttachment(const Texture& depth) {
  return depth.options().format == Format::kDepth32FStencil8 ? GL_DEPTH_STENCIL_ATTACHMENT
                                                             : GL_DEPTH_ATTACHMENT;
}

absl::StatusOr<ObjectName> Attach(Context& context, const Texture& color, const Texture* depth) {
  GLuint name = 0;
  glCreateFramebuffers(1, &name);
  ObjectName owned(context, name, &Delete);
  glNamedFramebufferTexture(name, GL_COLOR_ATTACHMENT0, color.name(), 0);
  if (depth != nullptr) {
    glNamedFramebufferTexture(name, DepthAttachment(*depth), depth->name(), 0);
  }
  const GLenum status = glCheckNamedFramebufferStatus(name, GL_FRAMEBUFFER);
  if (status != GL_FRAMEBUFFER_COMPLETE) {
    return absl::UnavailableError(
        absl::StrCat("gl::Framebuffer: the driver refuses it, 0x", absl::Hex(status)));
  }
  return owned;
}

}  // namespace

absl::StatusOr<Framebuffer> Framebuffer::Create(Context& context,
                                                const FramebufferOptions& options) {
  TextureOptions image = {.width = options.width,
                          .height = options.height,
                          .format = options.color,
                          .samples = options.samples};
  Framebuffer framebuffer;
  framebuffer.options_ = options;
  auto color = Texture::Create(context, image);
  if (!color.ok()) return color.status();
  if (options.has_depth) {
    image.format = options.has_stencil ? Format::kDepth32FStencil8 : Format::kDepth32F;
    auto depth = Texture::Create(context, image);
    if (!depth.ok()) return depth.status();
    framebuffer.depth_ = *std::move(depth);
  }
  auto name = Attach(context, *color, options.has_depth ? &framebuffer.depth_ : nullptr);
  if (!name.ok()) return name.status();
  framebuffer.color_ = *std::move(color);
  framebuffer.name_ = *std::move(name);
  if (options.samples == 1) return framebuffer;

  image.format = options.color;
  image.samples = 1;
  auto resolved = Texture::Create(context, image);
  if (!resolved.ok()) return resolved.status();
  auto resolved_name = Attach(context, *resolved, nullptr);
  if (!resolved_name.ok()) return resolved_name.status();
  framebuffer.resolved_color_ = *std::move(resolved);
  framebuffer.resolved_name_ = *std::move(resolved_name);
  return framebuffer;
}

void Framebuffer::Clear(Context& context, Vec4 color) {
  if (!context.MakeCurrent().ok()) return;
  const float farthest = 0.0f;
  // Masks hold for clearing too, and a draw may have left them off.
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glDepthMask(GL_TRUE);
  glDisable(GL_SCISSOR_TEST);
  glClearNamedFramebufferfv(name(), GL_COLOR, 0, &color.x);
  if (options_.has_depth) glClearNamedFramebufferfv(name(), GL_DEPTH, 0, &farthest);
}

void Framebuffer::ClearToZeros(Context& context) {
  if (!context.MakeCurrent().ok()) return;
  constexpr GLuint kZeros[4] = {};
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glDisable(GL_SCISSOR_TEST);
  glClearNamedFramebufferuiv(name(), GL_COLOR, 0, kZeros);
}

void Framebuffer::ClearStencil(Context& context, uint8_t value) {
  if (!options_.has_stencil || !context.MakeCurrent().ok()) return;
  const GLint cleared = value;
  glStencilMask(0xff);
  glDisable(GL_SCISSOR_TEST);
  glClearNamedFramebufferiv(name(), GL_STENCIL, 0, &cleared);
}

absl::StatusOr<std::vector<Vec4>> Framebuffer::ReadPixels(Context& context) {
  if (absl::Status status = context.MakeCurrent(); !status.ok()) return status;
  const int width = options_.width, height = options_.height;
  if (options_.samples > 1) {
    glDisable(GL_SCISSOR_TEST);  // it would hold for the copy too
    glBlitNamedFramebuffer(name(), resolved_name_.get(), 0, 0, width, height, 0, 0, width, height,
                           GL_COLOR_BUFFER_BIT, GL_NEAREST);
  }
  glBindFramebuffer(GL_READ_FRAMEBUFFER, options_.samples > 1 ? resolved_name_.get() : name());
  std::vector<Vec4> pixels(size_t{1} * width * height);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadnPixels(0, 0, width, height, GL_RGBA, GL_FLOAT,
                static_cast<GLsizei>(pixels.size() * sizeof(Vec4)), pixels.data());
  if (absl::Status status = context.Check("gl::Framebuffer::ReadPixels"); !status.ok()) {
    return status;
  }
  return pixels;
}

}  // namespace penumbra::gl
