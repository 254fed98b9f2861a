// The engine that a command works on, and the scene that it makes there for itself.
//
//   auto engine = OpenEngine(command.engine);
//   auto scene = TemporaryScene::Create(**engine, "bake");
//   (*engine)->Commit(scene->id(), delta);
#pragma once

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "client/cli/commands.h"
#include "render/engine/engine.h"

namespace penumbra {

// Errors  kUnavailable: no server at that address
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
