// The engine that a command works on, and the scene that it makes there for itself.
//
//   auto engine = OpenEngine(command.engine);
//   auto scene = TemporaryScene::Create(**engine, "bake");
//   (*engine)->Commit(scene->id(), delta);
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "client/cli/commands.h"
#include "client/cli/console.h"
#include "client/session/remote_engine.h"
#include "render/engine/engine.h"

namespace penumbra {

// The server that was chosen, with the token of its file or of the environment's PENUMBRA_TOKEN: a
// command line, which others on the machine can read, never has it.
//
//   progress       of uploads
//   console        says once that the computing of who calls is used up; null: nobody asks
//   on_connection  as in RemoteEngineOptions
//
// Errors  kInvalidArgument CANNOT_READ: no token in that file; those of RemoteEngine::Connect
absl::StatusOr<std::unique_ptr<RemoteEngine>> ConnectTo(
    const EngineChoice& choice, std::function<void(uint64_t, uint64_t)> progress = nullptr,
    const Console* console = nullptr,
    std::function<void(const ConnectionEvent&)> on_connection = nullptr);

// The scene as it is.
//
// Errors  kNotFound UNKNOWN_ID, "--scene": the server has none of that id; the error names those
//         that it has
absl::StatusOr<std::shared_ptr<const Scene>> SceneOf(Engine& engine, const std::string& scene_id);
// That error.
absl::Status UnknownScene(Engine& engine, const std::string& scene_id);

// Errors  those of ConnectTo, where a server was chosen
absl::StatusOr<std::unique_ptr<Engine>> OpenEngine(const EngineChoice& choice);

// A scene of a name that nobody else uses, deleted with this object.
class TemporaryScene {
 public:
  // Errors  those of CreateScene
  static absl::StatusOr<TemporaryScene> Create(Engine& engine, const std::string& stem);

  TemporaryScene(TemporaryScene&& other) noexcept;
  TemporaryScene& operator=(TemporaryScene&&) = delete;
  ~TemporaryScene();

  const std::string& id() const { return id_; }

 private:
  TemporaryScene(Engine* engine, std::string id) : engine_(engine), id_(std::move(id)) {}

  Engine* engine_;  // null once moved from
  std::string id_;
};

}  // namespace penumbra
