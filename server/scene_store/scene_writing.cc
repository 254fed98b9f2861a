// How commits get from their scenes' queues to the disk.

#include <algorithm>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "server/scene_store/scene_entry.h"
#include "server/scene_store/stored_scene.h"

namespace penumbra {
namespace {

// One transaction's: what comes meanwhile waits for it, and goes with the next.
constexpr size_t kMaxBatch = 512;

template <typename Batch>
std::vector<CommitRecord> RecordsOf(const Batch& batch) {
  std::vector<CommitRecord> records;
  records.reserve(batch.size());
  for (const auto& pending : batch) records.push_back(pending->Record());
  return records;
}

}  // namespace

CommitRecord SceneStore::Pending::Record() const {
  return {.revision = after->revision(),
          .content_hash = after->content_hash(),
          .key = request.idempotency_key,
          .fingerprint = request.fingerprint,
          .author = request.author_name,
          .time_ms = time_ms,
          .delta = DeltaBytes(*before, *after, request.delta)};
}

SceneStore::Batch SceneStore::Entry::NextBatch() {
  std::lock_guard lock(mutex);
  const size_t count = std::min(pending.size(), kMaxBatch);
  return {pending.begin(), pending.begin() + static_cast<ptrdiff_t>(count)};
}

SceneState SceneStore::Entry::Whole(const Scene& scene) {
  SceneState state;
  if (scene.revision() > 0) state.snapshot = SnapshotOf(scene);
  std::lock_guard lock(mutex);
  for (const std::string& key : answer_order) state.answers.push_back(answers.at(key));
  return state;
}

void SceneStore::Entry::Tidy(const Scene& last) {
  log->Tidy([&] { return SnapshotOf(last); }).IgnoreError();  // later, then
}

void SceneStore::PostWrite(const std::shared_ptr<Entry>& entry) {
  const auto now = StorageBacklog::Clock::now();
  if (!entry->log->is_in_journal()) {
    backlog_.OnPosted(WrittenTo::kFile, now);
    storage_->lane().Post([this, entry] { WritePending(entry); });
    return;
  }
  backlog_.OnPosted(WrittenTo::kJournal, now);
  if (for_journal_.Add(entry)) storage_->lane().Post([this] { WriteTogether(); });
}

// On a thread of the storage's, as the next two. For each scene there is one of these tasks at a
// time, or it is among those that are written together.
void SceneStore::WritePending(const std::shared_ptr<Entry>& entry) {
  backlog_.OnTaken(WrittenTo::kFile);
  const Batch batch = entry->NextBatch();
  // Nobody else publishes while this task is there, so that the first one's `before` is what counts
  // as acknowledged.
  const auto acknowledged = batch.front()->before;
  const absl::Status written =
      entry->log->Append(RecordsOf(batch), [&] { return entry->Whole(*acknowledged); });
  Conclude(*entry, batch, written);
  if (written.ok()) entry->Tidy(*batch.back()->after);
  GoOn(entry);
}

// What comes while the journal is synced goes with the next, which another task writes while this
// one tells what it has written.
void SceneStore::WriteTogether() {
  // One journal, or two while scenes move from an old one to the next.
  std::map<std::shared_ptr<JournalInUse>, std::vector<JournalPart>> journals;
  for (const auto& entry : for_journal_.Take()) {
    backlog_.OnTaken(WrittenTo::kJournal);
    Batch batch = entry->NextBatch();
    auto entered = entry->log->EnterJournal(RecordsOf(batch));
    if (entered) {
      journals[entered->journal].push_back({entry, std::move(batch), std::move(entered->entries)});
      continue;
    }
    // To its own file, and beside those of others.
    backlog_.OnPosted(WrittenTo::kFile, StorageBacklog::Clock::now());
    storage_->lane().Post([this, entry] { WritePending(entry); });
  }
  std::vector<std::pair<JournalPart*, absl::Status>> written;
  for (auto& [journal, parts] : journals) {
    JournalEntries all;
    for (const JournalPart& part : parts) all.push_back(part.entries);
    const absl::Status status = storage_->journals().Append(*journal, all);
    for (JournalPart& part : parts) written.emplace_back(&part, status);
  }
  if (for_journal_.PassOn()) storage_->lane().Post([this] { WriteTogether(); });
  for (const auto& [part, status] : written) ConcludePart(*part, status);
}

// Waits neither for the disk nor for who reads a history: the other scenes of the group come next.
void SceneStore::ConcludePart(JournalPart& part, const absl::Status& written) {
  Entry& entry = *part.entry;
  entry.log->LeaveJournal(std::move(part.entries), written.ok());
  Conclude(entry, part.batch, written);
  if (!written.ok() || !entry.log->is_tidying_due()) return GoOn(part.entry);
  // One at a time: scenes that become busy together would do it together, with all writers.
  if (is_tidying_.exchange(true)) return GoOn(part.entry);
  storage_->lane().Post([this, entry = part.entry, newest = part.batch.back()->after] {
    entry->Tidy(*newest);
    is_tidying_ = false;
    GoOn(entry);
  });
}

void SceneStore::GoOn(const std::shared_ptr<Entry>& entry) {
  std::lock_guard lock(entry->mutex);
  entry->is_writing = !entry->pending.empty();
  if (entry->is_writing) PostWrite(entry);
}

}  // namespace penumbra
