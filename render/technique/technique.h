// An algorithm that turns a scene and a spec into an artifact.
#pragma once

#include <functional>
#include <memory>
#include <stop_token>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "render/artifact/artifact.h"
#include "render/scene/scene.h"
#include "render/technique/artifact_spec.h"
#include "render/technique/technique_memory.h"
#include "tbb/task_arena.h"

namespace penumbra {

namespace gl {
class Context;
}

// Milliseconds on a clock that only goes forward; the one clock that computations may read.
using MonotonicClock = std::function<double()>;

// All that a computation may use.
struct ComputeContext {
  tbb::task_arena& arena;     // where CPU work runs
  gl::Context* gl = nullptr;  // current on this thread, or null
  std::string gl_error;       // where `gl` is null: why there is none, if anybody knows
  bool cpu_for_gl = false;    // `gl` is null, but should not be: the CPU does what takes GL
  std::stop_token stop;       // checked at least once per light sample
  std::function<void(Artifact)>
      progress;                       // takes coarse artifacts before the final one; may be null
  MonotonicClock now_ms;              // may be null: then no timings
  TechniqueMemory* memory = nullptr;  // of this artifact; null: nothing can be kept
};

// Immutable and without state of its own: any thread may use one, any number at a time.
class Technique {
 public:
  virtual ~Technique() = default;

  virtual const TechniqueInfo& info() const = 0;

  // Whether `spec` can be computed on `scene`, without computing.
  //
  // Errors  kInvalidArgument: a parameter; kNotFound: no such light or receiver;
  //         kFailedPrecondition: the receiver has no place
  virtual absl::Status Check(const Scene& scene, const ArtifactSpec& spec) const = 0;

  // Whether computing `spec` takes a GL context.
  virtual bool NeedsGl(const ArtifactSpec& /*spec*/) const { return false; }

  // The final artifact; the coarse ones before it go to `context.progress`.
  //
  // Errors  those of Check; kCancelled: stop requested
  virtual absl::StatusOr<Artifact> Compute(const Scene& scene, const ArtifactSpec& spec,
                                           const ComputeContext& context) const = 0;
};

// The technique that `params` belong to. Lives as long as the process.
const Technique& TechniqueFor(const TechniqueParams& params);

}  // namespace penumbra
