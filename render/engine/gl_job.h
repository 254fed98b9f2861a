// A job that takes GL: on the GL worker's thread while that can be relied on, by the CPU otherwise.
#pragma once

#include <functional>

#include "absl/status/statusor.h"
#include "render/gl/worker.h"
#include "render/technique/technique.h"

namespace penumbra {

// The worker for jobs that take GL; may make it when it is first asked. An error: there is none.
using GlWorkerSource = std::function<absl::StatusOr<gl::Worker*>()>;

// What the technique computes, of a spec that needs GL. A job that a fault befalls is run once more
// (gl::Worker). While the worker takes no jobs the CPU computes the spec, and the artifact says so
// in its header's parameter "without_gl". Where there never was GL the technique says what becomes
// of that.
//
// Errors  those of the technique; GL_CONTEXT_LOST (kUnavailable), GL_ERROR (kInternal),
//         GL_OUT_OF_MEMORY and QUOTA_GPU_BYTES (kResourceExhausted): a fault befell it twice
// Throws  what the technique does
absl::StatusOr<Artifact> ComputeOnGl(const Technique& technique, const Scene& scene,
                                     const ArtifactSpec& spec, const ComputeContext& context,
                                     const GlWorkerSource& worker_source);

// Whether the CPU computed what GL should have.
bool IsWithoutGl(const ArtifactHeader& header);

}  // namespace penumbra
