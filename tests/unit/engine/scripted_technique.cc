#include "tests/unit/engine/scripted_technique.h"

#include <stdexcept>

#include "render/scene/field_error.h"
#include "tests/support/shapes.h"

namespace penumbra::testing {

absl::Status ScriptedTechnique::Check(const Scene& scene, const ArtifactSpec& spec) const {
  if (std::get<SoftTextureParams>(spec.params).samples == 0) {
    return FieldError(absl::StatusCode::kInvalidArgument, "RANGE", "samples", "found 0, need 1");
  }
  if (scene.FindLight(spec.light_id) == nullptr) {
    return FieldError(absl::StatusCode::kNotFound, "UNKNOWN_ID", "light_id", "no such light");
  }
  return absl::OkStatus();
}

absl::StatusOr<Artifact> ScriptedTechnique::Compute(const Scene& scene, const ArtifactSpec& spec,
                                                    const ComputeContext& context) const {
  std::unique_lock lock(mutex_);
  jobs_.push_back({scene.revision(), context.stop});
  changed_.notify_all();
  absl::StatusOr<Artifact> result = absl::UnknownError("not told what to do");
  uint32_t pass = 0;
  const absl::Status check = Check(scene, spec);
  for (;;) {
    if (!check.ok()) {
      result = check;
      break;
    }
    if (!changed_.wait(lock, context.stop, [this] { return !commands_.empty(); })) {
      result = absl::CancelledError("stopped");
      break;
    }
    const Command command = commands_.front();
    commands_.pop_front();
    if (command.kind == Command::kPass) {
      lock.unlock();
      context.progress(LabelledArtifact(scene, pass++, false));
      lock.lock();
      ++passes_out_;
      changed_.notify_all();
      continue;
    }
    if (command.kind == Command::kThrow) {
      ++ended_;
      changed_.notify_all();
      throw std::runtime_error("thrown by the test");
    }
    if (command.kind == Command::kFail) result = command.status;
    if (command.kind == Command::kFinish) result = LabelledArtifact(scene, pass, true);
    break;
  }
  ++ended_;
  changed_.notify_all();
  return result;
}

ScriptedTechnique::Job ScriptedTechnique::AwaitJob(size_t index) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return jobs_.size() > index; });
  return jobs_[index];
}

void ScriptedTechnique::AwaitEnd(size_t index) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return ended_ > index; });
}

size_t ScriptedTechnique::jobs_begun() const {
  std::lock_guard lock(mutex_);
  return jobs_.size();
}

void ScriptedTechnique::Pass() {
  size_t before = 0;
  {
    std::lock_guard lock(mutex_);
    before = passes_out_;
  }
  Say({.kind = Command::kPass});
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return passes_out_ > before; });
}

void ScriptedTechnique::Say(Command command) {
  std::lock_guard lock(mutex_);
  commands_.push_back(std::move(command));
  changed_.notify_all();
}

Artifact LabelledArtifact(const Scene& scene, uint32_t pass, bool is_final) {
  Artifact artifact;
  artifact.header.scene_id = scene.id();
  artifact.header.revision = scene.revision();
  artifact.header.scene_hash = scene.content_hash();
  artifact.header.pass = pass;
  artifact.header.is_final = is_final;
  return artifact;
}

LocalEngineOptions OptionsFor(const Technique& technique) {
  return {.technique_for = [&technique](const TechniqueParams&) -> const Technique& {
    return technique;
  }};
}

ArtifactCallback UpdateLog::Callback() {
  return [this](const ArtifactUpdate& update) {
    std::lock_guard lock(mutex_);
    updates_.push_back(update);
    came_.notify_all();
  };
}

std::vector<ArtifactUpdate> UpdateLog::AwaitLast(
    const std::function<bool(const ArtifactUpdate&)>& done) {
  std::unique_lock lock(mutex_);
  came_.wait(lock, [&] { return !updates_.empty() && done(updates_.back()); });
  return updates_;
}

std::vector<ArtifactUpdate> UpdateLog::AwaitFinalAt(Revision revision) {
  return AwaitLast([=](const ArtifactUpdate& update) { return IsFinalAt(update, revision); });
}

std::vector<ArtifactUpdate> UpdateLog::AwaitCount(size_t count) {
  std::unique_lock lock(mutex_);
  came_.wait(lock, [&] { return updates_.size() >= count; });
  return updates_;
}

std::vector<ArtifactUpdate> UpdateLog::all() const {
  std::lock_guard lock(mutex_);
  return updates_;
}

bool IsFinalAt(const ArtifactUpdate& update, Revision revision) {
  return update.revision == revision && update.status.ok() && update.artifact->header.is_final;
}

SceneDelta LampAndFloor() {
  SceneDelta delta = BoxAt(0.0f);
  delta.upsert_lights = {{.id = "lamp", .shape = PointLight{.position = Vec3(0, 2, 0)}}};
  delta.upsert_receivers = {FloorReceiver("floor", 1.0f, 8)};
  return delta;
}

SceneDelta BoxAt(float x) {
  return {.upsert_instances = {{.id = "box",
                                .mesh = MeshOf(UnitBoxGeometry()),
                                .world_from_mesh = Placed(Vec3(x, 1, 0), 0.1f)}}};
}

ArtifactSpec LampOnFloor(uint64_t seed) {
  return {.params = SoftTextureParams{.seed = seed}, .light_id = "lamp", .receiver_id = "floor"};
}

}  // namespace penumbra::testing
