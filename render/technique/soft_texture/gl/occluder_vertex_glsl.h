// The vertex stage of OccluderProgram.
#pragma once

#include <string>

namespace penumbra::texture_gl {

// `masked`: the texture coordinates of the corners are handed on.
std::string OccluderVertexGlsl(bool masked);

}  // namespace penumbra::texture_gl
