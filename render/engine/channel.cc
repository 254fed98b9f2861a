#include "render/engine/channel.h"

#include <algorithm>
#include <exception>
#include <new>
#include <utility>

#include "absl/strings/str_cat.h"

namespace penumbra {

Channel::Channel(const std::string& scene_id, ArtifactSpec spec, const Technique& technique,
                 const JobResources& resources, std::shared_ptr<SceneMemory> scene_memory)
    : spec_(std::move(spec)),
      slot_(absl::StrCat(scene_id, " ", SpecKey(spec_))),
      technique_(technique),
      resources_(resources),
      memory_{.budget = resources.kept, .of_scene = std::move(scene_memory)} {
  ++*resources_.channels;
}

Channel::~Channel() { --*resources_.channels; }

void Channel::Add(std::shared_ptr<Subscriber> subscriber, std::shared_ptr<const Scene> scene) {
  std::lock_guard lock(mutex_);
  if (newest_) subscriber->Offer(*newest_);
  subscribers_.push_back(std::move(subscriber));
  if (head_) return;
  head_ = std::move(scene);
  if (PublishKnown()) return;
  NoteWanted();
  Enqueue();
}

bool Channel::PublishKnown() try {
  if (!resources_.results.is_on()) return false;
  const auto key = resources_.results.KeyOf(*head_, spec_);
  auto known = key ? resources_.results.FindInMemory(*key) : nullptr;
  if (!known) return false;
  ++resources_.counters.artifacts_published;
  Publish({head_->revision(), absl::OkStatus(), AsComputedOn(*head_, std::move(known))});
  return true;
} catch (const std::bad_alloc&) {
  return false;
}

bool Channel::Remove(const Subscriber* subscriber) {
  {
    std::lock_guard lock(mutex_);
    std::erase_if(subscribers_, [&](const auto& s) { return s.get() == subscriber; });
    if (!subscribers_.empty()) return false;
  }
  End(absl::OkStatus());
  return true;
}

void Channel::Join(const Party& party) {
  std::lock_guard lock(mutex_);
  if (++joined_[party] == 1) ShareAmongParties();
}

void Channel::Leave(const Party& party) {
  std::lock_guard lock(mutex_);
  const auto joined = joined_.find(party);
  if (joined == joined_.end() || --joined->second > 0) return;
  joined_.erase(joined);
  ShareAmongParties();
}

void Channel::ShareAmongParties() {
  auto parties = std::make_shared<Parties>();
  for (const auto& [party, count] : joined_) parties->push_back(party);
  parties_ = std::move(parties);
  if (queued_) resources_.jobs.Change(*this, Whom());
}

void Channel::OnCommit(std::shared_ptr<const Scene> after, SceneChange& change) {
  std::optional<std::stop_source> stop;
  {
    std::lock_guard lock(mutex_);
    head_ = std::move(after);
    if (ended_ || queued_) return;  // the job that waits will take the head
    const bool is_error = newest_ && !newest_->status.ok();
    if ((is_error && !job_) || change.Affects(spec_, region_)) {
      newest_is_stale_ = true;
      NoteWanted();
      if (!job_) {
        Enqueue();
      } else {
        job_->superseded = true;
        if (job_->published) stop = job_->stop;
      }
    } else {
      ++resources_.counters.unaffected_commits;
      if (job_ && !job_->superseded) job_->holds_until = head_->revision();
      if (newest_ && !newest_is_stale_ && !is_error) {
        ArtifactUpdate same = *newest_;
        same.revision = head_->revision();
        Publish(std::move(same));
      }
    }
  }
  if (stop) stop->request_stop();
}

void Channel::End(const absl::Status& reason) {
  std::optional<std::stop_source> stop;
  {
    std::lock_guard lock(mutex_);
    if (!ended_ && !reason.ok()) Publish({head_->revision(), reason, nullptr});
    ended_ = true;
    if (std::exchange(queued_, false)) resources_.jobs.Remove(*this);
    if (job_) stop = job_->stop;
  }
  if (stop) stop->request_stop();
}

Channel::Load Channel::load() {
  std::lock_guard lock(mutex_);
  return {.waits = queued_, .runs = job_.has_value()};
}

void Channel::NoteWanted() {
  if (!wanted_ms_) wanted_ms_ = NowMs();
}

void Channel::Enqueue() {
  queued_ = true;
  queued_ms_ = NowMs();
  resources_.jobs.Add(shared_from_this(), Whom(), last_job_ms_);
}

void Channel::Publish(ArtifactUpdate update) {
  for (const auto& subscriber : subscribers_) subscriber->Offer(update);
  newest_ = std::move(update);
}

void Channel::PublishLast(ArtifactUpdate update) {
  for (const auto& subscriber : subscribers_) subscriber->OfferNext(update);
  newest_ = std::move(update);
}

double Channel::Run() {
  std::shared_ptr<const Scene> scene;
  std::stop_token stop;
  {
    std::lock_guard lock(mutex_);
    queued_ = false;
    if (ended_) return 0;
    const double now_ms = NowMs();
    Job& job = job_.emplace(
        Job{.scene = head_,
            .holds_until = head_->revision(),
            .started_ms = now_ms,
            .wanted_ms = wanted_ms_.value_or(queued_ms_),
            .report = {.technique = technique_.info().name, .waited_ms = now_ms - queued_ms_}});
    wanted_ms_.reset();
    scene = job.scene;
    stop = job.stop.get_token();
  }
  ++resources_.counters.jobs_started;
  bool was_known = false;
  auto result = FindOrCompute(*scene, stop, was_known);
  JobReport report;
  {
    std::lock_guard lock(mutex_);
    job_->report.was_known = was_known;
    report = Finish(*std::exchange(job_, std::nullopt), std::move(result));
  }
  if (resources_.on_job) resources_.on_job(report);
  return report.computed_ms;
}

absl::StatusOr<std::shared_ptr<const Artifact>> Channel::FindOrCompute(const Scene& scene,
                                                                       std::stop_token stop,
                                                                       bool& was_known) {
  ResultCache& results = resources_.results;
  std::optional<ContentHash> key;
  try {
    if (results.is_on()) key = results.KeyOf(scene, spec_);
    if (auto known = key ? results.FindAnywhere(*key) : nullptr) {
      was_known = true;
      return AsComputedOn(scene, std::move(known));
    }
  } catch (const std::bad_alloc&) {
    was_known = false;  // to compute it may take less
  }
  auto result = Compute(scene, std::move(stop));
  if (!key || !result.ok() || IsWithoutGl((*result)->header)) return result;
  try {
    results.Keep(slot_, *key, *result);
  } catch (const std::bad_alloc&) {
    // It is computed again, then.
  }
  return result;
}

absl::StatusOr<std::shared_ptr<const Artifact>> Channel::Compute(const Scene& scene,
                                                                 std::stop_token stop) {
  const ComputeContext context{.arena = resources_.arena,
                               .stop = std::move(stop),
                               .progress = [this](Artifact pass) { OnPass(std::move(pass)); },
                               .now_ms = resources_.now_ms,
                               .memory = &memory_};
  try {
    absl::StatusOr<Artifact> artifact =
        technique_.NeedsGl(spec_)
            ? ComputeOnGl(technique_, scene, spec_, context, resources_.gl_worker)
            : technique_.Compute(scene, spec_, context);
    if (!artifact.ok()) return artifact.status();
    return std::make_shared<const Artifact>(*std::move(artifact));
  } catch (const std::bad_alloc&) {
    return absl::ResourceExhaustedError(
        absl::StrCat(std::string(technique_.info().name), ": out of memory"));
  } catch (const std::exception& error) {
    return absl::InternalError(
        absl::StrCat(std::string(technique_.info().name), ": ", error.what()));
  }
}

void Channel::OnPass(Artifact artifact) {
  std::optional<std::stop_source> stop;
  const uint32_t pass = artifact.header.pass;
  auto shared = std::make_shared<const Artifact>(std::move(artifact));
  {
    std::lock_guard lock(mutex_);
    if (ended_ || !job_ || (job_->superseded && job_->published)) return;
    if (pass < job_->next_pass) return;
    job_->next_pass = pass + 1;
    if (!std::exchange(job_->published, true)) {
      ++resources_.counters.first_passes;
      job_->report.first_artifact_ms = NowMs() - job_->wanted_ms;
    }
    ++resources_.counters.artifacts_published;
    if (job_->superseded) stop = job_->stop;
    newest_is_stale_ = job_->superseded;
    Publish({job_->holds_until, absl::OkStatus(), std::move(shared)});
  }
  if (stop) stop->request_stop();
}

JobReport Channel::Finish(Job job, absl::StatusOr<std::shared_ptr<const Artifact>> result) {
  EngineCounters& counters = resources_.counters;
  const double now_ms = NowMs();
  job.report.computed_ms = now_ms - job.started_ms;
  // What a lookup takes says nothing of the next job.
  if (!job.report.was_known) last_job_ms_ = job.report.computed_ms;
  job.report.status = result.status();
  const bool superseded_and_shown = job.superseded && job.published;
  if (ended_ || superseded_and_shown || (job.superseded && absl::IsCancelled(result.status()))) {
    ++counters.jobs_cancelled;
    job.report.outcome = JobReport::Outcome::kSuperseded;
  } else if (!result.ok()) {
    ++counters.jobs_failed;
    job.report.outcome = JobReport::Outcome::kFailed;
    newest_is_stale_ = job.superseded;
    PublishLast({job.holds_until, result.status(), nullptr});
  } else {
    ++counters.jobs_finished;
    ++counters.artifacts_published;
    if (!job.published) ++counters.first_passes;
    job.report.final_artifact_ms = now_ms - job.wanted_ms;
    if (!job.published) job.report.first_artifact_ms = job.report.final_artifact_ms;
    newest_is_stale_ = job.superseded;
    PublishLast({job.holds_until, absl::OkStatus(), *std::move(result)});
  }
  // Commits that do not affect an artifact may still mend an error.
  const bool may_be_mended = !result.ok() && head_ != job.scene;
  if (!ended_ && (job.superseded || may_be_mended)) Enqueue();
  return std::move(job.report);
}

}  // namespace penumbra
