// The server's OpenGL: one worker, or why there is none.
#pragma once

#include <memory>

#include "absl/status/statusor.h"
#include "penumbra/v1/server_info.pb.h"
#include "render/gl/worker.h"
#include "server/gl_health.h"
#include "server/penumbra_server.h"

namespace penumbra {

using GlWorker = absl::StatusOr<std::unique_ptr<gl::Worker>>;

// The server's clock for everything that computes, milliseconds.
double SteadyNowMs();

// `health`, which outlives the worker, is told whether it can be relied on.
GlWorker OpenGl(const ServerOptions& options, GlHealth& health);

// Errors  kFailedPrecondition NO_GPU: options.require_gpu, and there is none
absl::Status CheckGpu(const ServerOptions& options, const GlWorker& worker);

v1::GlInfo GlInfoOf(const GlWorker& worker);

}  // namespace penumbra
