// One artifact kept up to date for all who subscribe to it: a scene's newest snapshot goes in, jobs
// run one at a time, and their artifacts go to every subscriber.
//
// Which job runs, when commits come faster than jobs end: the newest revision wins, but not at the
// price of silence. A commit that affects the artifact supersedes the running job; the job's stop
// token fires at once if the job has published something, and otherwise right after it publishes
// its first, coarse pass (under the revision it holds for). So a steady stream of commits still
// yields one coarse artifact a job, no job computes more than that for a past revision, and the
// revision after which the stream pauses is computed to the end.
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "render/engine/engine.h"
#include "render/engine/engine_statistics.h"
#include "render/engine/gl_job.h"
#include "render/engine/job_queue.h"
#include "render/engine/job_report.h"
#include "render/engine/result_cache.h"
#include "render/engine/scene_change.h"
#include "render/engine/subscriber.h"
#include "render/technique/technique.h"
#include "tbb/task_arena.h"

namespace penumbra {

// What jobs run on. Outlives the jobs, not the channels.
struct JobResources {
  JobQueue& jobs;
  tbb::task_arena& arena;
  MonotonicClock now_ms;
  EngineCounters& counters;
  MemoryBudget& kept;    // for what techniques keep between jobs
  ResultCache& results;  // outlives the channels, too
  GlWorkerSource gl_worker;
  JobObserver on_job;                             // may be null
  std::shared_ptr<std::atomic<size_t>> channels;  // of the engine, counted by themselves
};

class Channel : public QueuedJob, public std::enable_shared_from_this<Channel> {
 public:
  Channel(const std::string& scene_id, ArtifactSpec spec, const Technique& technique,
          const JobResources& resources, std::shared_ptr<SceneMemory> scene_memory);
  ~Channel() override;

  // The first subscriber starts the first job, unless the artifact is known. Later ones get the
  // newest artifact at once.
  void Add(std::shared_ptr<Subscriber> subscriber, std::shared_ptr<const Scene> scene);
  // Whether it was the last one; then the job that waits or runs is cancelled.
  bool Remove(const Subscriber* subscriber);

  // Whom its jobs are done for (party.h).
  void Join(const Party& party);
  void Leave(const Party& party);

  // Calls come in the order of the commits.
  void OnCommit(std::shared_ptr<const Scene> after, SceneChange& change);

  // How much of people's pictures the receiver fills, all together: jobs of larger ones run first.
  double viewed_share() const override { return viewed_share_; }
  void SetViewedShare(double share) { viewed_share_ = share; }
  const ArtifactSpec& spec() const { return spec_; }
  // Whether a job waits for a thread, and whether one runs.
  struct Load {
    bool waits = false;
    bool runs = false;
  };
  Load load();

  // Computes for the newest scene; by the job queue alone.
  double Run() override;

  // Cancels the job and says `reason`, if it is an error, to all subscribers as the last
  // word.
  void End(const absl::Status& reason);

 private:
  struct Job {
    std::shared_ptr<const Scene> scene;
    Revision holds_until =
        0;  // later than the scene's after commits that do not affect the artifact
    std::stop_source stop{};
    bool published = false;
    uint32_t next_pass = 0;  // those before have been published, perhaps by an earlier attempt
    bool superseded = false;
    double started_ms = 0;
    double wanted_ms = 0;  // when the oldest change came that this job answers
    JobReport report{};
  };

  double NowMs() const { return resources_.now_ms ? resources_.now_ms() : 0; }
  void NoteWanted();  // with the lock held, as for all of these
  void Enqueue();
  JobFor Whom() const { return {head_->id(), parties_}; }
  void ShareAmongParties();
  void Publish(ArtifactUpdate update);
  void PublishLast(ArtifactUpdate update);  // as the last thing that a job does
  JobReport Finish(Job job, absl::StatusOr<std::shared_ptr<const Artifact>> result);

  void OnPass(Artifact artifact);
  bool PublishKnown();  // with the lock held
  absl::StatusOr<std::shared_ptr<const Artifact>> FindOrCompute(const Scene& scene,
                                                                std::stop_token stop,
                                                                bool& was_known);
  absl::StatusOr<std::shared_ptr<const Artifact>> Compute(const Scene& scene, std::stop_token stop);

  const ArtifactSpec spec_;
  const std::string slot_;  // of results
  const Technique& technique_;
  const JobResources resources_;
  std::atomic<double> viewed_share_ = 0;

  std::mutex mutex_;
  std::shared_ptr<const Scene> head_;
  KnownShadowRegion region_;
  std::vector<std::shared_ptr<Subscriber>> subscribers_;
  std::map<Party, size_t> joined_;          // how often
  std::shared_ptr<const Parties> parties_;  // of joined_; null: none
  std::optional<ArtifactUpdate> newest_;    // last published
  bool newest_is_stale_ = false;            // a commit has affected it since
  bool queued_ = false;
  bool ended_ = false;
  double queued_ms_ = 0;
  std::optional<double> wanted_ms_;  // the oldest change that no job has begun to answer
  std::optional<Job> job_;           // the one that runs
  double last_job_ms_ = 0;           // what the one before took; 0: there was none
  TechniqueMemory memory_;           // the running job's
};

}  // namespace penumbra
