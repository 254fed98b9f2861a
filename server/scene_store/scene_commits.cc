// The way of a commit: checked, sent to the disk (scene_writing.cc), told.

#include <algorithm>
#include <chrono>
#include <utility>

#include "absl/strings/str_cat.h"
#include "render/scene/field_error.h"
#include "server/scene_store/commit_admission.h"
#include "server/scene_store/scene_entry.h"

namespace penumbra {
namespace {

absl::Status CheckKey(const std::string& key, uint32_t max_bytes) {
  if (key.size() > max_bytes) {
    return FieldError(absl::StatusCode::kInvalidArgument, "BAD_ID", "idempotency_key",
                      "found " + std::to_string(key.size()) + " bytes, need at most " +
                          std::to_string(max_bytes));
  }
  return CheckId(key, "idempotency_key");
}

absl::Status KeyReused(const std::string& key) {
  return FieldError(absl::StatusCode::kInvalidArgument, "REQUEST_ID_REUSED", "idempotency_key",
                    "found '" + key + "', which stands for another delta, need a new key");
}

int64_t UtcNowMs() {
  return std::chrono::duration_cast<std::chrono::milliseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

absl::Status SceneIsDeleted() {
  return FieldError(absl::StatusCode::kNotFound, "UNKNOWN_ID", "scene_id",
                    "found a scene that was deleted, need a scene");
}

CommitOutcome AnswerOf(const CommitRecord& first) {
  return {.revision = first.revision, .content_hash = first.content_hash, .scene = nullptr};
}

}  // namespace

SceneStore::Recalled SceneStore::Recall(const Entry& entry, const std::string& key,
                                        const ContentHash& fingerprint) const {
  if (auto status = CheckKey(key, limits_.max_idempotency_key_bytes); !status.ok()) return status;
  const auto first = entry.answers.find(key);
  if (first == entry.answers.end()) return std::nullopt;
  if (first->second.fingerprint != fingerprint) return KeyReused(key);
  return AnswerOf(first->second);
}

void SceneStore::Remember(Entry& entry, const CommitRecord& answer) {
  // In an archive, which may come from anywhere, a key can come twice: the newest counts.
  if (entry.answers.contains(answer.key)) std::erase(entry.answer_order, answer.key);
  entry.answers[answer.key] = answer;
  entry.answer_order.push_back(answer.key);
  if (entry.answer_order.size() <= limits_.max_idempotency_keys) return;
  entry.answers.erase(entry.answer_order.front());
  entry.answer_order.pop_front();
}

SceneStore::Recalled SceneStore::FirstAnswer(const std::string& scene_id,
                                             const std::string& idempotency_key,
                                             const ContentHash& fingerprint) {
  const auto found = Find(scene_id);
  if (!found.ok()) return found.status();
  std::lock_guard lock((*found)->mutex);
  return Recall(**found, idempotency_key, fingerprint);
}

bool SceneStore::HasCommit(const std::string& scene_id, const std::string& idempotency_key) const {
  if (idempotency_key.empty()) return false;
  const auto found = Find(scene_id);
  if (!found.ok()) return false;
  std::lock_guard lock((*found)->mutex);
  return (*found)->answers.contains(idempotency_key) ||
         std::ranges::any_of((*found)->pending, [&](const std::shared_ptr<Pending>& pending) {
           return pending->request.idempotency_key == idempotency_key;
         });
}

void SceneStore::Commit(const std::string& scene_id, CommitRequest request,
                        std::weak_ptr<const SceneWatcher> author, CommitCallback done) {
  const auto found = Find(scene_id);
  if (!found.ok()) return done(found.status());
  const std::shared_ptr<Entry>& entry = *found;
  const std::string& key = request.idempotency_key;
  std::unique_lock lock(entry->mutex);
  if (!key.empty()) {
    const auto first = Recall(*entry, key, request.fingerprint);
    if (!first.ok() || *first) {
      lock.unlock();
      return done(first.ok() ? absl::StatusOr<CommitOutcome>(**first) : first.status());
    }
    for (const auto& other : entry->pending) {
      if (other->request.idempotency_key != key) continue;
      if (other->request.fingerprint == request.fingerprint) {
        other->done.push_back(std::move(done));
        return;
      }
      lock.unlock();
      return done(KeyReused(key));
    }
  }
  auto pending = std::make_shared<Pending>(Pending{.request = std::move(request),
                                                   .author = std::move(author),
                                                   .before = entry->newest,
                                                   .time_ms = UtcNowMs(),
                                                   .done = {std::move(done)}});
  absl::StatusOr<CommitOutcome> outcome = Prepare(*entry, *pending);
  if (outcome.ok() && entry->log) return Send(entry, std::move(pending));
  if (outcome.ok()) outcome = Publish(*entry, *pending);
  if (outcome.ok()) entry->newest = pending->after;
  lock.unlock();
  pending->done.front()(outcome);
}

void SceneStore::Send(const std::shared_ptr<Entry>& entry, std::shared_ptr<Pending> pending) {
  entry->newest = pending->after;
  pending->came = StorageBacklog::Clock::now();
  entry->pending_bytes += pending->request.bytes;
  backlog_.Add(pending->request.principal, pending->request.bytes);
  entry->pending.push_back(std::move(pending));
  if (!std::exchange(entry->is_writing, true)) PostWrite(entry);
}

absl::StatusOr<CommitOutcome> SceneStore::Prepare(Entry& entry, Pending& pending) const {
  if (entry.is_deleted) return SceneIsDeleted();
  if (auto status = Admit(entry, pending.request); !status.ok()) return status;
  auto after = entry.newest->Apply(pending.request.delta, limits_.scene);
  if (!after.ok()) return after.status();
  pending.after = *std::move(after);
  return CommitOutcome{};
}

absl::Status SceneStore::Admit(const Entry& entry, const CommitRequest& request) const {
  if (!storage_) return absl::OkStatus();
  SceneBacklog scene{
      .commits = entry.pending.size(), .bytes = entry.pending_bytes, .oldest_came = {}};
  if (!entry.pending.empty()) scene.oldest_came = entry.pending.front()->came;
  return AdmitCommit(request, scene, backlog_, limits_, StorageBacklog::Clock::now());
}

absl::StatusOr<CommitOutcome> SceneStore::Publish(Entry& entry, const Pending& pending) {
  const std::shared_ptr<const Scene>& scene = pending.after;
  if (auto status = engine_.Publish(scene, pending.request.delta); !status.ok()) return status;
  ++counters_.commits;
  if (!pending.request.idempotency_key.empty()) {
    Remember(entry, {.revision = scene->revision(),
                     .content_hash = scene->content_hash(),
                     .key = pending.request.idempotency_key,
                     .fingerprint = pending.request.fingerprint,
                     .author = pending.request.author_name,
                     .time_ms = pending.time_ms});
  }
  const auto author = pending.author.lock();
  std::erase_if(entry.watchers, [&](const std::weak_ptr<SceneWatcher>& weak) {
    const auto watcher = weak.lock();
    if (watcher && watcher != author) watcher->OnScene(scene);
    return watcher == nullptr;
  });
  return CommitOutcome{scene->revision(), scene->content_hash(), scene};
}

void SceneStore::Conclude(Entry& entry, const Batch& batch, const absl::Status& written) {
  std::vector<std::pair<CommitCallback, absl::StatusOr<CommitOutcome>>> answers;
  {
    std::lock_guard lock(entry.mutex);
    std::deque<std::shared_ptr<Pending>> concluded(batch.begin(), batch.end());
    // What builds on a commit that is not there goes with it.
    if (!written.ok()) concluded.swap(entry.pending);
    for (const auto& pending : concluded) {
      entry.pending_bytes -= pending->request.bytes;
      backlog_.Remove(pending->request.principal, pending->request.bytes);
      const absl::StatusOr<CommitOutcome> outcome =
          written.ok() && !entry.is_deleted
              ? Publish(entry, *pending)
              : absl::StatusOr<CommitOutcome>(entry.is_deleted ? SceneIsDeleted() : written);
      bool is_first = true;
      for (CommitCallback& done : pending->done) {
        answers.emplace_back(std::move(done), outcome);
        if (outcome.ok() && !is_first) answers.back().second->scene = nullptr;
        is_first = false;
      }
    }
    if (written.ok()) {
      entry.pending.erase(entry.pending.begin(),
                          entry.pending.begin() + static_cast<ptrdiff_t>(batch.size()));
      if (!entry.is_deleted) storage_->Note(*entry.log, batch.back()->after->revision());
    } else {
      entry.pending.clear();
      entry.newest = batch.front()->before;
    }
  }
  for (const auto& [done, outcome] : answers) done(outcome);
}

}  // namespace penumbra
