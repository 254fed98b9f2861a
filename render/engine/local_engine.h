// Computes in this process.
//
//   LocalEngine engine({.cpu_threads = 4});
//   engine.CreateScene("studio");
//   engine.Commit("studio", delta);
//   auto artifact = ComputeOnce(engine, "studio", spec);  // render/engine/compute_once.h
//
// Jobs run on a few runner threads, which hand their loops to one TBB arena. Jobs for points, final
// pictures for instance, may take minutes: they have one runner more, one arena and one turn after
// another among themselves, so that nothing else waits for them. Callbacks run on delivery threads,
// so that neither a long job nor a slow callback keeps updates from the others.
// A callback that is slower than the updates come sees the newest and misses those in between.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/engine/compute_accounts.h"
#include "render/engine/engine.h"
#include "render/engine/engine_statistics.h"
#include "render/engine/job_report.h"
#include "render/engine/party.h"
#include "render/engine/result_cache.h"
#include "render/scene/scene_limits.h"
#include "render/technique/technique.h"

namespace penumbra {

class LiveScene;
namespace gl {
class Worker;
}

struct LocalEngineOptions {
  // That jobs share, and as many for jobs for points; 0: as many as the hardware has.
  int cpu_threads = 0;
  int runner_threads = 2;    // jobs that run at a time, besides one for points
  int delivery_threads = 2;  // callbacks that run at a time
  // What techniques may keep in all to answer edits faster; 0: nothing.
  size_t max_kept_bytes = size_t{256} << 20;
  ResultCacheOptions results{};  // final artifacts that were computed; by default none
  SceneLimits scene_limits{};
  size_t max_scenes = 256;
  // Different artifacts (technique, parameters, light, receiver) that are followed on one scene,
  // and on all of them. Each has at most one job waiting, so these bound the queue.
  size_t max_artifacts_per_scene = 1024;
  size_t max_artifacts = 16'384;
  size_t max_viewers_per_scene = 1024;
  MonotonicClock now_ms = nullptr;  // null: artifacts carry no timings
  // For specs that take GL. Null: they end in an error. The worker must outlive the engine, or the
  // function own it.
  std::function<absl::StatusOr<gl::Worker*>()> gl_worker = nullptr;
  JobObserver on_job = nullptr;  // told of every job that has ended; see job_report.h
  // Null: all principals are alike. It must outlive the engine.
  ComputeAccounts* accounts = nullptr;
  // What computes a spec; tests put their own here. It must outlive the engine.
  std::function<const Technique&(const TechniqueParams&)> technique_for = TechniqueFor;
};

class LocalEngine : public Engine, public SharedEngine {
 public:
  explicit LocalEngine(LocalEngineOptions options = {});
  // Cancels all jobs and waits for them and for the callbacks that run. Subscriptions may be
  // destroyed before or after.
  ~LocalEngine() override;

  absl::Status CreateScene(const std::string& scene_id) override;
  // Creates a scene that is as `scene` is, at its revision. Errors  those of CreateScene
  absl::Status RestoreScene(std::shared_ptr<const Scene> scene);
  absl::Status DeleteScene(const std::string& scene_id) override;
  absl::StatusOr<std::vector<SceneInfo>> ListScenes() override;
  absl::StatusOr<Revision> Commit(const std::string& scene_id, const SceneDelta& delta) override;
  // The second half of a commit: makes `after`, which is the scene's head with `delta` applied, the
  // head. For whoever has something to do between finding out that a delta is good and telling it.
  // Errors  kNotFound: no such scene; kAborted STALE_BASE: there has been another commit
  absl::Status Publish(std::shared_ptr<const Scene> after, const SceneDelta& delta);
  absl::StatusOr<std::shared_ptr<const Scene>> Snapshot(const std::string& scene_id) override;
  // A light or receiver that is not there is no error here: the first update says so, and the
  // commit that adds it mends it. Errors, further  kResourceExhausted QUOTA_ARTIFACTS
  //
  // The subscription may be destroyed from inside its own callback, which is then the last call.
  absl::StatusOr<std::unique_ptr<Subscription>> Subscribe(const std::string& scene_id,
                                                          const ArtifactSpec& spec,
                                                          ArtifactCallback callback) override;
  // The same for a named party; others may join.
  absl::StatusOr<std::unique_ptr<SharedSubscription>> SubscribeFor(
      const Party& party, const std::string& scene_id, const ArtifactSpec& spec,
      ArtifactCallback callback) override;

  // Errors, further  kResourceExhausted QUOTA_VIEWERS
  absl::Status ReportView(const std::string& scene_id, const std::string& viewer,
                          const std::optional<View>& view) override;

  EngineStatistics statistics() const;
  ResultStatistics result_statistics() const { return results_.statistics(); }
  // What there is to do for each scene, in the order of their ids.
  struct SceneLoad {
    SceneInfo scene;
    size_t artifacts = 0;  // that somebody follows
    size_t jobs_waiting = 0;
    size_t jobs_running = 0;
  };
  std::vector<SceneLoad> scene_loads() const;
  // Threads that a job may use.
  int cpu_threads() const;

 private:
  struct Scenes;
  struct Threads;

  absl::StatusOr<std::unique_ptr<SharedSubscription>> Follow(const Party* party,
                                                             const std::string& scene_id,
                                                             const ArtifactSpec& spec,
                                                             ArtifactCallback callback);
  absl::StatusOr<std::shared_ptr<LiveScene>> Find(const std::string& scene_id) const;
  std::vector<std::shared_ptr<LiveScene>> All() const;

  const LocalEngineOptions options_;
  EngineCounters counters_;
  MemoryBudget kept_;
  ResultCache results_;
  const std::unique_ptr<Scenes> scenes_;
  const std::unique_ptr<Threads> threads_;
};

}  // namespace penumbra
