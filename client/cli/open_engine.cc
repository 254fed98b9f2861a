#include "client/cli/open_engine.h"

#include <cstdlib>
#include <fstream>
#include <random>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/cli/option_error.h"
#include "client/session/steady_clock.h"
#include "render/engine/local_engine.h"
#include "render/gl/lazy_worker.h"

namespace penumbra {

absl::StatusOr<std::unique_ptr<RemoteEngine>> ConnectTo(
    const EngineChoice& choice, std::function<void(uint64_t, uint64_t)> progress) {
  RemoteEngineOptions options{.address = choice.server,
                              .upload_progress = std::move(progress),
                              .credentials = choice.credentials};
  ClientCredentials& credentials = options.credentials;
  credentials.tls |= !credentials.ca_file.empty() || !credentials.certificate_file.empty() ||
                     !credentials.key_file.empty();
  if (!choice.token_file.empty()) {
    std::ifstream file(choice.token_file);
    if (!(file >> credentials.token)) {
      return OptionError("--token-file", "CANNOT_READ", {choice.token_file.native()},
                         ", need a file with a token");
    }
  } else if (const char* token = std::getenv("PENUMBRA_TOKEN")) {
    credentials.token = token;
  }
  return RemoteEngine::Connect(std::move(options));
}

absl::StatusOr<std::unique_ptr<Engine>> OpenEngine(const EngineChoice& choice) {
  if (choice.server.empty()) {
    const auto gl = std::make_shared<gl::LazyWorker>(gl::WorkerOptions{});
    return std::make_unique<LocalEngine>(LocalEngineOptions{
        .cpu_threads = static_cast<int>(choice.threads), .now_ms = NowMs, .gl_worker = [gl] {
          return gl->Get();
        }});
  }
  return ConnectTo(choice);
}

absl::StatusOr<TemporaryScene> TemporaryScene::Create(Engine& engine, const std::string& stem) {
  std::random_device random;
  // 128 bits: nobody guesses it.
  std::string id = absl::StrCat(stem, "-");
  for (int i = 0; i < 4; ++i) absl::StrAppend(&id, absl::Hex(random(), absl::kZeroPad8));
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
