// Scenes, and the artifacts computed from them: in this process (LocalEngine) or on a server
// (RemoteEngine, client/session). One interface, so that where the work is done is one constructor.
//
//   engine.CreateScene("studio");
//   engine.Commit("studio", delta);
//   auto subscription = engine.Subscribe("studio", spec, [](const ArtifactUpdate& update) { … });
//
// Every method may be called from any thread, but not from inside a callback of the same engine.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "render/artifact/artifact.h"
#include "render/scene/camera.h"
#include "render/scene/scene.h"
#include "render/technique/artifact_spec.h"

namespace penumbra {

// What a subscriber is told. Updates of one subscription come one at a time, in the order of their
// revisions and, within one, of their passes. Revisions may be left out, the newest never is.
struct ArtifactUpdate {
  // The newest revision for which `artifact` holds. It can be newer than the one the artifact was
  // computed on: commits that cannot change it do not compute it again.
  Revision revision = 0;
  // kOk with an artifact; otherwise why there is none at this revision (its light was removed, for
  // instance). The subscription goes on, and recovers with the commit that mends it.
  absl::Status status;
  std::shared_ptr<const Artifact> artifact;  // null if and only if `status` is an error
};

using ArtifactCallback = std::function<void(const ArtifactUpdate&)>;

// Ends when destroyed; no callback runs after that, and destroying waits for one that does.
class Subscription {
 public:
  virtual ~Subscription() = default;
};

struct SceneInfo {
  std::string id;
  Revision revision = 0;
  ContentHash content_hash;
  size_t instance_count = 0;
  size_t light_count = 0;
  size_t receiver_count = 0;
};

class Engine {
 public:
  virtual ~Engine() = default;

  // Errors  kAlreadyExists; kInvalidArgument BAD_ID; kResourceExhausted QUOTA_SCENES
  virtual absl::Status CreateScene(const std::string& scene_id) = 0;
  // Ends the scene's subscriptions with kNotFound. Errors  kNotFound
  virtual absl::Status DeleteScene(const std::string& scene_id) = 0;
  virtual absl::StatusOr<std::vector<SceneInfo>> ListScenes() = 0;

  // Applies `delta` whole or not at all. Returns the new revision; from then on every subscription
  // will reach it. Errors  those of Scene::Apply; kNotFound: no such scene
  virtual absl::StatusOr<Revision> Commit(const std::string& scene_id, const SceneDelta& delta) = 0;

  // The newest snapshot that this engine knows of. Errors  kNotFound
  virtual absl::StatusOr<std::shared_ptr<const Scene>> Snapshot(const std::string& scene_id) = 0;

  // Calls `callback`, from threads of the engine's, with the artifact of `spec` at the present
  // revision (coarse passes first) and again whenever a commit changes it.
  //
  // Errors  kInvalidArgument: a parameter; kNotFound: no such scene
  virtual absl::StatusOr<std::unique_ptr<Subscription>> Subscribe(const std::string& scene_id,
                                                                  const ArtifactSpec& spec,
                                                                  ArtifactCallback callback) = 0;

  // Says what `viewer` (any name) looks at; nullopt: nothing any more. Of the artifacts that wait
  // to be computed, those whose receivers fill most of all viewers' pictures come first.
  //
  // Errors  kNotFound: no such scene; kInvalidArgument: the view, its field named
  virtual absl::Status ReportView(const std::string& scene_id, const std::string& viewer,
                                  const std::optional<View>& view) = 0;
};

}  // namespace penumbra
