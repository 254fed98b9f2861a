// The depth source that a technique's parameters ask for.
#pragma once

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "render/light_view/caster_bvh.h"
#include "render/light_view/depth_method.h"
#include "render/light_view/depth_source.h"
#include "tbb/task_arena.h"

namespace penumbra {

namespace gl {
class Context;
}

// All outlive the source.
struct DepthSourceMeans {
  CasterBvhs& bvhs;
  tbb::task_arena& arena;
  gl::Context* gl = nullptr;  // current on this thread, or null
  std::string gl_error;       // where `gl` is null: why there is none, if anybody knows
  bool cpu_for_gl = false;    // where `gl` is null: the CPU draws in its place
};

// field   of the parameters, that `method` comes from: "layered_attenuation.depth_method"
// Errors  kFailedPrecondition, NO_GL, at the field: kGl without a context or cpu_for_gl
absl::StatusOr<std::unique_ptr<DepthSource>> MakeDepthSource(DepthMethod method, const Scene& scene,
                                                             const DepthSourceMeans& means,
                                                             std::string field);

}  // namespace penumbra
