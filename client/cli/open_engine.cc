#include "client/cli/open_engine.h"

#include <random>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/session/remote_engine.h"
#include "client/session/steady_clock.h"
#include "render/engine/local_engine.h"
#include "render/gl/lazy_worker.h"

namespace penumbra {

absl::StatusOr<std::unique_ptr<Engine>> OpenEngine(const EngineChoice& choice) {
  if (choice.server.empty()) {
    const auto gl = std::make_shared<gl::LazyWorker>(gl::WorkerOptions{});
    return std::make_unique<LocalEngine>(LocalEngineOptions{
        .cpu_threads = static_cast<int>(choice.threads), .now_ms = NowMs, .gl_worker = [gl] {
          return gl->Get();
        }});
  }
  return RemoteEngine::Connect({.address = choice.server});
}

absl::StatusOr<TemporaryScene> TemporaryScene::Create(Engine& engine, const std::string& stem) {
  std::random_device random;
  std::string id = absl::StrCat(stem, "-", absl::Hex(random(), absl::kZeroPad8),
                                absl::Hex(random(), absl::kZeroPad8));
  if (absl::Status status = engine.CreateScene(id); !status.ok()) return status;
  return TemporaryScene(&engine, std::move(id));
}

TemporaryScene::TemporaryScene(TemporaryScene&& other) noexcept
    : engine_(std::exchange(other.engine_, nullptr)), id_(std::move(other.id_)) {}

TemporaryScene::~TemporaryScene() {
  // A server that has gone away takes its scenes with it.
  if (engine_ != nullptr) engine_->DeleteScene(id_).IgnoreError();
}

}  // namespace penumbra
