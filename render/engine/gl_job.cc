#include "render/engine/gl_job.h"

#include <exception>
#include <string>
#include <utility>

#include "render/scene/field_error.h"

namespace penumbra {
namespace {

constexpr char kWithoutGl[] = "without_gl";

absl::StatusOr<Artifact> ComputeByCpu(const Technique& technique, const Scene& scene,
                                      const ArtifactSpec& spec, const ComputeContext& context,
                                      const std::string& reason) {
  ComputeContext by_cpu = context;
  by_cpu.cpu_for_gl = true;
  if (context.progress) {
    by_cpu.progress = [&](Artifact pass) {
      pass.header.parameters[kWithoutGl] = reason;
      context.progress(std::move(pass));
    };
  }
  auto artifact = technique.Compute(scene, spec, by_cpu);
  if (artifact.ok()) artifact->header.parameters[kWithoutGl] = reason;
  return artifact;
}

absl::StatusOr<Artifact> RunOn(gl::Worker& worker, const Technique& technique, const Scene& scene,
                               const ArtifactSpec& spec, const ComputeContext& context) {
  absl::StatusOr<Artifact> artifact = absl::UnavailableError("GL worker: the job did not run");
  // What the technique throws must not end the worker's thread.
  std::exception_ptr thrown;
  const absl::Status status = worker.Run([&](gl::Context& gl_context) -> absl::Status {
    if (context.stop.stop_requested()) return absl::CancelledError("stop requested");
    ComputeContext on_gl = context;
    on_gl.gl = &gl_context;
    thrown = nullptr;
    try {
      artifact = technique.Compute(scene, spec, on_gl);
    } catch (...) {
      thrown = std::current_exception();
    }
    return artifact.status();
  });
  if (thrown) std::rethrow_exception(thrown);
  if (!status.ok()) return status;
  return artifact;
}

}  // namespace

bool IsWithoutGl(const ArtifactHeader& header) { return header.parameters.contains(kWithoutGl); }

absl::StatusOr<Artifact> ComputeOnGl(const Technique& technique, const Scene& scene,
                                     const ArtifactSpec& spec, const ComputeContext& context,
                                     const GlWorkerSource& worker_source) {
  const auto worker = worker_source ? worker_source()
                                    : absl::UnavailableError("this engine was made without OpenGL");
  if (!worker.ok()) {
    ComputeContext without = context;
    without.gl_error = std::string(worker.status().message());
    return technique.Compute(scene, spec, without);
  }
  const gl::WorkerHealth& health = (*worker)->health();
  if (health.TakesJobs()) {
    auto artifact = RunOn(**worker, technique, scene, spec, context);
    const gl::Fault fault = gl::FaultOf(artifact.status());
    if (fault == gl::Fault::kNone) return artifact;
    if (health.TakesJobs()) {
      return FieldError(artifact.status().code(), gl::ReasonOf(fault), "",
                        std::string(artifact.status().message()));
    }
  }
  return ComputeByCpu(technique, scene, spec, context, health.reason());
}

}  // namespace penumbra
