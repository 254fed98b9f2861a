#include "server/gl_worker.h"

#include <chrono>
#include <string>

#include "render/scene/field_error.h"

namespace penumbra {

double SteadyNowMs() {
  return std::chrono::duration<double, std::milli>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

GlWorker OpenGl(const ServerOptions& options, GlHealth& health) {
  if (!options.opens_gl) return absl::UnavailableError("switched off");
  auto worker = gl::Worker::Create(
      {.context = {.device = options.egl_device,
                   .max_memory_bytes = options.gpu_memory_bytes,
                   .now_ms = SteadyNowMs,
                   .inject_fault = options.inject_gl_fault},
       .on_health_change = [&health](bool is_degraded) { health.Set(!is_degraded); }});
  health.Set(worker.ok());
  return worker;
}

absl::Status CheckGpu(const ServerOptions& options, const GlWorker& worker) {
  if (!options.require_gpu) return absl::OkStatus();
  if (worker.ok() && !(*worker)->info().is_software) return absl::OkStatus();
  return FieldError(absl::StatusCode::kFailedPrecondition, "NO_GPU", "require-gpu",
                    "found " +
                        (worker.ok() ? (*worker)->info().renderer + ", which is software"
                                     : std::string(worker.status().message())) +
                        ", need a hardware device");
}

v1::GlInfo GlInfoOf(const GlWorker& worker) {
  v1::GlInfo proto;
  if (!worker.ok()) {
    proto.set_error(std::string(worker.status().message()));
    return proto;
  }
  proto.set_error((*worker)->health().reason());
  const gl::ContextInfo info = (*worker)->info();
  proto.set_device(info.device.name);
  proto.set_vendor(info.vendor);
  proto.set_renderer(info.renderer);
  proto.set_version(info.version);
  return proto;
}

}  // namespace penumbra
