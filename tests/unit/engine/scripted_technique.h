// Techniques without geometry, for tests of scheduling.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <vector>

#include "render/engine/local_engine.h"
#include "render/technique/technique.h"

namespace penumbra::testing {

// Each job waits to be told what to do, and ends as kCancelled when its stop token fires.
//
//   const auto job = technique.AwaitJob(0);   // blocks until the first job runs
//   technique.Pass();                         // it publishes a coarse artifact
//   technique.Finish();                       // it returns the final one
class ScriptedTechnique : public Technique {
 public:
  struct Job {
    Revision revision;
    std::stop_token stop;
  };

  const TechniqueInfo& info() const override { return SoftTextureParams::kInfo; }
  // kInvalidArgument for 0 samples, kNotFound for a light that is not there.
  absl::Status Check(const Scene& scene, const ArtifactSpec& spec) const override;
  absl::StatusOr<Artifact> Compute(const Scene& scene, const ArtifactSpec& spec,
                                   const ComputeContext& context) const override;

  // The job that began as number `index`, once it has begun.
  Job AwaitJob(size_t index);
  // Blocks until job number `index` has returned from Compute.
  void AwaitEnd(size_t index);
  size_t jobs_begun() const;

  // To the one job that runs, or the next to run. Pass blocks until the coarse artifact is out.
  void Pass();
  void Finish() { Say({.kind = Command::kFinish}); }
  void Fail(absl::Status status) { Say({.kind = Command::kFail, .status = std::move(status)}); }
  void Throw() { Say({.kind = Command::kThrow}); }

 private:
  struct Command {
    enum Kind { kPass, kFinish, kFail, kThrow } kind;
    absl::Status status{};
  };

  void Say(Command command);

  mutable std::mutex mutex_;
  mutable std::condition_variable_any changed_;
  mutable std::deque<Command> commands_;
  mutable std::vector<Job> jobs_;
  mutable size_t ended_ = 0;
  mutable size_t passes_out_ = 0;
};

// Calls `compute`.
class FunctionTechnique : public Technique {
 public:
  using Function = std::function<absl::StatusOr<Artifact>(const Scene&, const ArtifactSpec&,
                                                          const ComputeContext&)>;
  explicit FunctionTechnique(Function compute) : compute_(std::move(compute)) {}

  const TechniqueInfo& info() const override { return SoftTextureParams::kInfo; }
  absl::Status Check(const Scene&, const ArtifactSpec&) const override { return absl::OkStatus(); }
  absl::StatusOr<Artifact> Compute(const Scene& scene, const ArtifactSpec& spec,
                                   const ComputeContext& context) const override {
    return compute_(scene, spec, context);
  }

 private:
  const Function compute_;
};

// An artifact that says of itself what it was computed from, and no more.
Artifact LabelledArtifact(const Scene& scene, uint32_t pass, bool is_final);

LocalEngineOptions OptionsFor(const Technique& technique);

// The updates that a callback got, in order; blocks until those asked for have come.
class UpdateLog {
 public:
  ArtifactCallback Callback();
  // All updates, when `done` is true of the last one.
  std::vector<ArtifactUpdate> AwaitLast(const std::function<bool(const ArtifactUpdate&)>& done);
  std::vector<ArtifactUpdate> AwaitFinalAt(Revision revision);
  std::vector<ArtifactUpdate> AwaitCount(size_t count);
  std::vector<ArtifactUpdate> all() const;

 private:
  mutable std::mutex mutex_;
  std::condition_variable came_;
  std::vector<ArtifactUpdate> updates_;
};

bool IsFinalAt(const ArtifactUpdate& update, Revision revision);

// A light "lamp" 2 m above the floor receiver "floor" of 1 m, and an occluder "box" between them.
SceneDelta LampAndFloor();
// The box at `x` metres along the floor; 0 is between lamp and floor, 10 is out of the way.
SceneDelta BoxAt(float x);
ArtifactSpec LampOnFloor(uint64_t seed = 1);

}  // namespace penumbra::testing
