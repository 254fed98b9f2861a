// The error of a parameter that asks for OpenGL where there is none.
//
//   if (context.gl == nullptr) return NoGl("soft_texture.method", "gl", context.gl_error);
#pragma once

#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "render/scene/field_error.h"

namespace penumbra {

// kFailedPrecondition, NO_GL, at `field`, whose value `found` asks for GL.
//
// gl_error  why there is none, if anybody knows
inline absl::Status NoGl(std::string_view field, std::string_view found,
                         std::string_view gl_error) {
  return FieldError(absl::StatusCode::kFailedPrecondition, "NO_GL", field,
                    absl::StrCat("found ", std::string(found),
                                 ", need an engine with an OpenGL context, or another method",
                                 gl_error.empty() ? "" : ": ", std::string(gl_error)));
}

}  // namespace penumbra
