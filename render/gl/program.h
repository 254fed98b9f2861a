// A compiled GLSL program.
//
//   auto program = gl::Program::Create(context, {.vertex = kVertex, .fragment = kFragment});
//   if (!program.ok()) return program.status();   // carries the compiler's log
//   program->Set(context, "clip_from_world", matrix);
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "render/gl/context.h"
#include "render/math/vec.h"

namespace penumbra::gl {

// The stages' texts, without a #version line; either `compute` or the other two. `constants` is put
// before each: GLSL constants written by C++ (see GlslConstant).
struct ProgramSource {
  std::string vertex{};
  std::string fragment{};
  std::string compute{};
  std::string constants{};
};

// "const float kName = 0.5;\n", so that a number lives in C++ alone.
std::string GlslConstant(std::string_view name, double value);
std::string GlslConstant(std::string_view name, int value);

class Program {
 public:
  // Errors  kInternal: it does not compile or link; the message has the driver's log
  static absl::StatusOr<Program> Create(Context& context, const ProgramSource& source);

  uint32_t name() const { return name_.get(); }

  // Names that the program does not use are ignored, as GL does.
  void Set(Context& context, const char* uniform, int value);
  void Set(Context& context, const char* uniform, uint32_t value);
  void Set(Context& context, const char* uniform, float value);
  void Set(Context& context, const char* uniform, glm::ivec2 value);
  void Set(Context& context, const char* uniform, Vec2 value);
  void Set(Context& context, const char* uniform, Vec3 value);
  void Set(Context& context, const char* uniform, Vec4 value);
  void Set(Context& context, const char* uniform, const Mat4& value);

 private:
  int Location(Context& context, const char* uniform) const;

  ObjectName name_;
};

}  // namespace penumbra::gl
