#include "render/engine/local_engine.h"

#include <algorithm>
#include <atomic>
#include <map>
#include <mutex>
#include <utility>

#include "absl/strings/str_cat.h"
#include "render/engine/live_scene.h"
#include "render/scene/field_error.h"
#include "tbb/global_control.h"
#include "tbb/info.h"

namespace penumbra {
namespace {

int CpuThreads(const LocalEngineOptions& options) {
  return options.cpu_threads > 0 ? options.cpu_threads : tbb::info::default_concurrency();
}

class LocalSubscription : public SharedSubscription {
 public:
  LocalSubscription(std::weak_ptr<LiveScene> scene, ArtifactSpec spec,
                    std::shared_ptr<Subscriber> subscriber)
      : scene_(std::move(scene)), spec_(std::move(spec)), subscriber_(std::move(subscriber)) {}
  ~LocalSubscription() override {
    subscriber_->Close();
    if (const auto scene = scene_.lock()) scene->Unsubscribe(spec_, subscriber_.get());
  }
  void Join(const Party& party) override {
    if (const auto scene = scene_.lock()) scene->Join(spec_, party);
  }
  void Leave(const Party& party) override {
    if (const auto scene = scene_.lock()) scene->Leave(spec_, party);
  }

 private:
  const std::weak_ptr<LiveScene> scene_;  // gone with the scene or the engine
  const ArtifactSpec spec_;
  const std::shared_ptr<Subscriber> subscriber_;
};

SceneInfo InfoOf(const Scene& head) {
  return {.id = head.id(),
          .revision = head.revision(),
          .content_hash = head.content_hash(),
          .instance_count = head.instances().size(),
          .light_count = head.lights().size(),
          .receiver_count = head.receivers().size()};
}

}  // namespace

struct LocalEngine::Scenes {
  std::mutex mutex;
  std::map<std::string, std::shared_ptr<LiveScene>> by_id;
};

struct LocalEngine::Threads {
  // TBB starts no more threads than the hardware has unless told to.
  tbb::global_control parallelism;
  tbb::task_arena arena;
  // A picture's loops keep the threads that have entered them to its end.
  tbb::task_arena point_arena;
  WorkerPool workers;
  JobQueue jobs;
  JobQueue point_jobs;
  const std::shared_ptr<std::atomic<size_t>> channels = std::make_shared<std::atomic<size_t>>(0);

  WorkerPool::Lane& deliveries() { return workers.lane(0); }

  explicit Threads(const LocalEngineOptions& options)
      : parallelism(tbb::global_control::max_allowed_parallelism,
                    std::max(2 * CpuThreads(options), tbb::info::default_concurrency())),
        arena(CpuThreads(options)),
        point_arena(CpuThreads(options)),
        workers({options.delivery_threads, options.runner_threads, /*for points*/ 1}),
        jobs(workers.lane(1), options.accounts),
        point_jobs(workers.lane(2), options.accounts) {}
};

LocalEngine::LocalEngine(LocalEngineOptions options)
    : options_(std::move(options)),
      kept_(options_.max_kept_bytes),
      results_(options_.results),
      scenes_(std::make_unique<Scenes>()),
      threads_(std::make_unique<Threads>(options_)) {}

LocalEngine::~LocalEngine() {
  std::map<std::string, std::shared_ptr<LiveScene>> scenes;
  {
    std::lock_guard lock(scenes_->mutex);
    scenes.swap(scenes_->by_id);
  }
  for (const auto& [id, scene] : scenes) scene->End(absl::OkStatus());
  threads_->workers.Stop();
}

absl::Status LocalEngine::CreateScene(const std::string& scene_id) {
  if (absl::Status id = CheckId(scene_id, "scene_id"); !id.ok()) return id;
  return RestoreScene(Scene::Empty(scene_id));
}

absl::Status LocalEngine::RestoreScene(std::shared_ptr<const Scene> scene) {
  const std::string scene_id = scene->id();
  std::lock_guard lock(scenes_->mutex);
  if (scenes_->by_id.contains(scene_id)) {
    return FieldError(absl::StatusCode::kAlreadyExists, "DUPLICATE_ID", "scene_id",
                      absl::StrCat("found '", scene_id, "', which exists; need an id not in use"));
  }
  if (scenes_->by_id.size() >= options_.max_scenes) {
    return FieldError(absl::StatusCode::kResourceExhausted, "QUOTA_SCENES", "scene_id",
                      absl::StrCat("found ", scenes_->by_id.size(), " scenes, need fewer than ",
                                   options_.max_scenes, " before another"));
  }
  scenes_->by_id.emplace(scene_id, std::make_shared<LiveScene>(std::move(scene)));
  return absl::OkStatus();
}

absl::Status LocalEngine::DeleteScene(const std::string& scene_id) {
  auto scene = Find(scene_id);
  if (!scene.ok()) return scene.status();
  {
    std::lock_guard lock(scenes_->mutex);
    const auto found = scenes_->by_id.find(scene_id);
    if (found != scenes_->by_id.end() && found->second == *scene) scenes_->by_id.erase(found);
  }
  (*scene)->End(
      FieldError(absl::StatusCode::kNotFound, "UNKNOWN_ID", "scene_id",
                 absl::StrCat("found '", scene_id, "', which was deleted; need a scene")));
  return absl::OkStatus();
}

absl::StatusOr<std::vector<SceneInfo>> LocalEngine::ListScenes() {
  std::vector<SceneInfo> infos;
  for (const auto& scene : All()) infos.push_back(InfoOf(*scene->Snapshot()));
  return infos;
}

absl::StatusOr<Revision> LocalEngine::Commit(const std::string& scene_id, const SceneDelta& delta) {
  auto scene = Find(scene_id);
  if (!scene.ok()) return scene.status();
  return (*scene)->Commit(delta, options_.scene_limits);
}

absl::Status LocalEngine::Publish(std::shared_ptr<const Scene> after, const SceneDelta& delta) {
  auto scene = Find(after->id());
  if (!scene.ok()) return scene.status();
  return (*scene)->Publish(std::move(after), delta);
}

absl::StatusOr<std::shared_ptr<const Scene>> LocalEngine::Snapshot(const std::string& scene_id) {
  auto scene = Find(scene_id);
  if (!scene.ok()) return scene.status();
  return (*scene)->Snapshot();
}

absl::Status LocalEngine::ReportView(const std::string& scene_id, const std::string& viewer,
                                     const std::optional<View>& view) {
  auto scene = Find(scene_id);
  if (!scene.ok()) return scene.status();
  if (view) {
    if (auto status = CheckView(*view, options_.scene_limits); !status.ok()) return status;
  }
  return (*scene)->ReportView(viewer, view, options_.max_viewers_per_scene);
}

absl::StatusOr<std::unique_ptr<Subscription>> LocalEngine::Subscribe(const std::string& scene_id,
                                                                     const ArtifactSpec& spec,
                                                                     ArtifactCallback callback) {
  return Follow(nullptr, scene_id, spec, std::move(callback));
}

absl::StatusOr<std::unique_ptr<SharedSubscription>> LocalEngine::SubscribeFor(
    const Party& party, const std::string& scene_id, const ArtifactSpec& spec,
    ArtifactCallback callback) {
  return Follow(&party, scene_id, spec, std::move(callback));
}

absl::StatusOr<std::unique_ptr<SharedSubscription>> LocalEngine::Follow(const Party* party,
                                                                        const std::string& scene_id,
                                                                        const ArtifactSpec& spec,
                                                                        ArtifactCallback callback) {
  auto scene = Find(scene_id);
  if (!scene.ok()) return scene.status();
  const Technique& technique = options_.technique_for(spec.params);
  const absl::Status check = technique.Check(*(*scene)->Snapshot(), spec);
  if (absl::IsInvalidArgument(check)) return check;
  auto subscriber =
      std::make_shared<Subscriber>(std::move(callback), threads_->deliveries(), counters_);
  const bool is_for_points = InfoOf(spec.params).target == SpecTarget::kPoints;
  const JobResources resources{.jobs = is_for_points ? threads_->point_jobs : threads_->jobs,
                               .arena = is_for_points ? threads_->point_arena : threads_->arena,
                               .now_ms = options_.now_ms,
                               .counters = counters_,
                               .kept = kept_,
                               .results = results_,
                               .gl_worker = options_.gl_worker,
                               .on_job = options_.on_job,
                               .channels = threads_->channels};
  const LiveScene::ChannelLimits limits{.of_scene = options_.max_artifacts_per_scene,
                                        .in_all = options_.max_artifacts};
  const absl::Status subscribed =
      (*scene)->Subscribe(spec, technique, resources, limits, subscriber, party);
  if (!subscribed.ok()) return subscribed;
  return std::make_unique<LocalSubscription>(*scene, spec, std::move(subscriber));
}

EngineStatistics LocalEngine::statistics() const { return counters_.Read(); }

std::vector<LocalEngine::SceneLoad> LocalEngine::scene_loads() const {
  std::vector<SceneLoad> loads;
  for (const auto& scene : All()) {
    const LiveScene::Load load = scene->load();
    loads.push_back({.scene = InfoOf(*scene->Snapshot()),
                     .artifacts = load.artifacts,
                     .jobs_waiting = load.jobs_waiting,
                     .jobs_running = load.jobs_running});
  }
  return loads;
}

int LocalEngine::cpu_threads() const { return CpuThreads(options_); }

std::vector<std::shared_ptr<LiveScene>> LocalEngine::All() const {
  std::lock_guard lock(scenes_->mutex);
  std::vector<std::shared_ptr<LiveScene>> scenes;
  for (const auto& [id, scene] : scenes_->by_id) scenes.push_back(scene);
  return scenes;
}

absl::StatusOr<std::shared_ptr<LiveScene>> LocalEngine::Find(const std::string& scene_id) const {
  std::lock_guard lock(scenes_->mutex);
  const auto found = scenes_->by_id.find(scene_id);
  if (found != scenes_->by_id.end()) return found->second;
  return FieldError(absl::StatusCode::kNotFound, "UNKNOWN_ID", "scene_id",
                    absl::StrCat("found '", scene_id, "', need the id of a scene"));
}

}  // namespace penumbra
