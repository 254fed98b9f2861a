#include "render/gl/program.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "render/gl/gl.h"

namespace penumbra::gl {
namespace {

absl::string_view View(std::string_view text) { return {text.data(), text.size()}; }

void DeleteProgram(uint32_t name) { glDeleteProgram(name); }
void DeleteShader(uint32_t name) { glDeleteShader(name); }

std::string ShaderLog(GLuint shader) {
  GLint length = 0;
  glGetShaderiv(shader, GL_INFO_LOG_LENGTH, &length);
  std::string log(length, '\0');
  glGetShaderInfoLog(shader, length, nullptr, log.data());
  return log.c_str();
}

std::string ProgramLog(GLuint program) {
  GLint length = 0;
  glGetProgramiv(program, GL_INFO_LOG_LENGTH, &length);
  std::string log(length, '\0');
  glGetProgramInfoLog(program, length, nullptr, log.data());
  return log.c_str();
}

absl::StatusOr<ObjectName> Compile(Context& context, GLenum stage, const char* stage_name,
                                   const std::string& constants, const std::string& text) {
  ObjectName shader(context, glCreateShader(stage), &DeleteShader);
  const std::string whole = absl::StrCat("#version 450 core\n", constants, "#line 1\n", text);
  const char* pointer = whole.c_str();
  glShaderSource(shader.get(), 1, &pointer, nullptr);
  glCompileShader(shader.get());
  GLint compiled = GL_FALSE;
  glGetShaderiv(shader.get(), GL_COMPILE_STATUS, &compiled);
  if (!compiled) {
    context.TakeMessages();  // the log says the same
    context.NoteFault(Fault::kError);
    return FaultError(Fault::kError,
                      absl::StrCat("GLSL: the ", stage_name, " shader does not compile:\n",
                                   ShaderLog(shader.get())));
  }
  return shader;
}

}  // namespace

std::string GlslConstant(std::string_view name, double value) {
  return absl::StrFormat("const float %s = %.9e;\n", View(name), value);
}

std::string GlslConstant(std::string_view name, int value) {
  return absl::StrFormat("const int %s = %d;\n", View(name), value);
}

absl::StatusOr<Program> Program::Create(Context& context, const ProgramSource& source) {
  if (absl::Status status = context.MakeCurrent(); !status.ok()) return status;
  struct Stage {
    GLenum kind;
    const char* name;
    const std::string& text;
  };
  const Stage stages[] = {{GL_VERTEX_SHADER, "vertex", source.vertex},
                          {GL_FRAGMENT_SHADER, "fragment", source.fragment},
                          {GL_COMPUTE_SHADER, "compute", source.compute}};
  Program program;
  program.name_ = ObjectName(context, glCreateProgram(), &DeleteProgram);
  for (const Stage& stage : stages) {
    if (stage.text.empty()) continue;
    auto shader = Compile(context, stage.kind, stage.name, source.constants, stage.text);
    if (!shader.ok()) return shader.status();
    glAttachShader(program.name(), shader->get());  // lives on until the program goes
  }
  glLinkProgram(program.name());
  GLint linked = GL_FALSE;
  glGetProgramiv(program.name(), GL_LINK_STATUS, &linked);
  if (!linked) {
    context.TakeMessages();
    context.NoteFault(Fault::kError);
    return FaultError(Fault::kError, absl::StrCat("GLSL: the program does not link:\n",
                                                  ProgramLog(program.name())));
  }
  if (absl::Status status = context.Check("gl::Program"); !status.ok()) return status;
  return program;
}

int Program::Location(Context& context, const char* uniform) const {
  return context.MakeCurrent().ok() ? glGetUniformLocation(name(), uniform) : -1;
}

void Program::Set(Context& context, const char* uniform, int value) {
  glProgramUniform1i(name(), Location(context, uniform), value);
}
void Program::Set(Context& context, const char* uniform, uint32_t value) {
  glProgramUniform1ui(name(), Location(context, uniform), value);
}
void Program::Set(Context& context, const char* uniform, float value) {
  glProgramUniform1f(name(), Location(context, uniform), value);
}
void Program::Set(Context& context, const char* uniform, glm::ivec2 value) {
  glProgramUniform2i(name(), Location(context, uniform), value.x, value.y);
}
void Program::Set(Context& context, const char* uniform, Vec2 value) {
  glProgramUniform2fv(name(), Location(context, uniform), 1, &value.x);
}
void Program::Set(Context& context, const char* uniform, Vec3 value) {
  glProgramUniform3fv(name(), Location(context, uniform), 1, &value.x);
}
void Program::Set(Context& context, const char* uniform, Vec4 value) {
  glProgramUniform4fv(name(), Location(context, uniform), 1, &value.x);
}
void Program::Set(Context& context, const char* uniform, const Mat4& value) {
  glProgramUniformMatrix4fv(name(), Location(context, uniform), 1, GL_FALSE, &value[0].x);
}

}  // namespace penumbra::gl
