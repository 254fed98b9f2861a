#include "client/cli/open_engine.h"

#include <atomic>
#include <cstdlib>
#include <fstream>
#include <random>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client/cli/option_error.h"
#include "client/session/steady_clock.h"
#include "render/engine/local_engine.h"
#include "render/gl/lazy_worker.h"

namespace penumbra {
namespace {

std::function<void(const absl::Status&)> NoteOnce(const Console& console) {
  return
      [&console, is_told = std::make_shared<std::atomic<bool>>(false)](const absl::Status& quota) {
        if (quota.ok() || is_told->exchange(true)) return;
        console.Note(absl::StrCat("over the quota: ", OneLine(std::string(quota.message()))));
      };
}

}  // namespace

absl::StatusOr<std::unique_ptr<RemoteEngine>> ConnectTo(
    const EngineChoice& choice, std::function<void(uint64_t, uint64_t)> progress,
    const Console* console, std::function<void(const ConnectionEvent&)> on_connection) {
  RemoteEngineOptions options{.address = choice.server,
                              .on_connection = std::move(on_connection),
                              .upload_progress = std::move(progress),
                              .credentials = choice.credentials};
  if (console != nullptr) options.on_compute_quota = NoteOnce(*console);
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

absl::Status UnknownScene(Engine& engine, const std::string& scene_id) {
  const auto present = engine.ListScenes();
  if (!present.ok()) return present.status();
  std::vector<std::string> ids;
  for (const SceneInfo& info : *present) ids.push_back(info.id);
  return UnknownIdError("--scene", scene_id, ids, "the server");
}

absl::StatusOr<std::shared_ptr<const Scene>> SceneOf(Engine& engine, const std::string& scene_id) {
  auto scene = engine.Snapshot(scene_id);
  if (absl::IsNotFound(scene.status())) return UnknownScene(engine, scene_id);
  return scene;
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
