#include "server/scene_store/scene_log.h"

#include <utility>

#include "render/scene/field_error.h"

namespace penumbra {
namespace {

// A scene whose last commits came within so short a time is busy.
constexpr std::chrono::milliseconds kBusy{250};
// One without commits for so long is not any more.
constexpr std::chrono::seconds kRest{1};

// What a scene has in the journal before it is moved, which takes one transaction; and how many
// times as much there is at most while it waits for its turn.
constexpr size_t kManyJournalled = 256;
constexpr uint64_t kManyJournalledBytes = 1u << 20;
constexpr size_t kMostTimesAsMany = 4;

}  // namespace

SceneLog::SceneLog(DataDirectory& directory, SharedJournal& journals, SceneLogOptions options,
                   std::unique_ptr<SceneFile> file)
    : directory_(directory),
      journals_(journals),
      options_(options),
      identity_(file->identity()),
      file_(std::move(file)),
      head_(file_->head()) {}

SceneLog::~SceneLog() {
  TakeLeft();
  if (journal_ && (!file_ || !Write({}, nullptr).ok())) journal_->Keep();
}

absl::Status SceneLog::Append(std::span<const CommitRecord> commits,
                              const std::function<SceneState()>& whole) {
  const auto lock = Lock();
  if (is_removed_) return CheckFile();
  if (!file_) {
    if (auto status = BeginAnew(whole()); !status.ok()) return status;
  }
  const auto now = Clock::now();
  std::shared_ptr<JournalInUse> journal;
  // Where there is none the file alone will do.
  if (now - last_append_ < kBusy) journal = journals_.Current().value_or(nullptr);
  last_append_ = now;
  return Write(commits, std::move(journal));
}

absl::Status SceneLog::Write(std::span<const CommitRecord> commits,
                             std::shared_ptr<JournalInUse> journal) {
  // What fails to be written is still in the journal, and only there.
  const size_t before = journalled_.size();
  journalled_.insert(journalled_.end(), commits.begin(), commits.end());
  const absl::Status status = file_->Append(journalled_, journal ? journal->id() : std::string());
  if (!status.ok()) journalled_.resize(before);
  if (status.ok()) {
    Name(std::move(journal));
  } else if (!absl::IsResourceExhausted(status)) {
    // Room on the disk is asked for before anything counts as written: a full one leaves no doubt.
    // After any other error the file may name the journal, or may not.
    if (journal) journal->Keep();
    Abandon();
  }
  return status;
}

// Of the file as it is now.
void SceneLog::Name(std::shared_ptr<JournalInUse> journal) {
  journalled_.clear();
  journalled_bytes_ = 0;
  head_ = file_->head();
  journal_ = std::move(journal);
  is_in_journal_ = journal_ != nullptr;
}

void SceneLog::Abandon() {
  file_->Abandon();
  file_.reset();
  is_in_journal_ = false;
}

absl::Status SceneLog::BeginAnew(const SceneState& whole) {
  const auto number = directory_.NextNumber(identity_.scene_id);
  if (!number.ok()) return number.status();
  auto file = SceneFile::Create(directory_.ScenePath(identity_.scene_id, *number), identity_,
                                options_.database, whole);
  if (!file.ok()) return file.status();
  if (auto status = (*file)->Settle(); !status.ok()) return status;
  file_ = *std::move(file);
  Name(nullptr);
  // The old ones are passed over from here on, whether or not they can be removed.
  directory_.RemoveScene(identity_.scene_id, *number).IgnoreError();
  return absl::OkStatus();
}

std::optional<SceneLog::Entered> SceneLog::EnterJournal(std::vector<CommitRecord> commits) {
  // Whoever has it may be waiting for the disk: that is to hold up no other scene.
  const auto lock = TryLock();
  if (!lock.owns_lock() || !file_ || !journal_ || journal_->has_failed()) return std::nullopt;
  if (has_journalled(kMostTimesAsMany)) return std::nullopt;
  uint64_t bytes = 0;
  for (const CommitRecord& commit : commits) bytes += commit.delta.size();
  // All scenes wait for what is written together; large commits fill a transaction of their own.
  if (bytes > kManyJournalledBytes) return std::nullopt;
  Entered entered{.journal = journal_, .entries = {}};
  entered.entries.reserve(commits.size());
  ContentHash chain = head_.chain;
  for (CommitRecord& commit : commits) {
    const ChainLink link = LinkOf(chain, commit);
    chain = link.chain;
    entered.entries.push_back(
        {.incarnation = identity_.incarnation, .chained = {std::move(commit), link}});
  }
  last_append_ = Clock::now();
  is_entered_ = true;
  return entered;
}

void SceneLog::LeaveJournal(std::vector<JournalEntry> entries, bool were_written) {
  std::lock_guard lock(left_mutex_);
  left_ = {.entries = std::move(entries), .were_written = were_written};
}

std::unique_lock<std::mutex> SceneLog::Lock() {
  std::unique_lock lock(mutex_);
  TakeLeft();
  return lock;
}

std::unique_lock<std::mutex> SceneLog::TryLock() {
  std::unique_lock lock(mutex_, std::try_to_lock);
  if (lock.owns_lock()) TakeLeft();
  return lock;
}

void SceneLog::TakeLeft() {
  std::optional<Left> left;
  {
    std::lock_guard lock(left_mutex_);
    left.swap(left_);
  }
  if (!left) return;
  is_entered_ = false;
  if (!left->were_written) return;
  for (JournalEntry& entry : left->entries) {
    CommitRecord& commit = entry.chained.commit;
    head_ = {.revision = commit.revision, .chain = entry.chained.link.chain};
    journalled_bytes_ += commit.delta.size();
    journalled_.push_back(std::move(commit));
  }
}

bool SceneLog::has_journalled(size_t times_many) const {
  return journalled_.size() >= times_many * kManyJournalled ||
         journalled_bytes_ >= times_many * kManyJournalledBytes;
}

bool SceneLog::is_snapshot_due() const {
  return pins_ == 0 &&
         file_->is_snapshot_due(options_.history, journalled_.size(), journalled_bytes_);
}

bool SceneLog::is_tidying_due() {
  // While somebody has it there will be another time.
  const auto lock = TryLock();
  return lock.owns_lock() && file_ && (has_journalled(1) || is_snapshot_due());
}

absl::Status SceneLog::Tidy(const std::function<SnapshotRecord()>& snapshot) {
  const auto lock = Lock();
  if (!file_) return absl::OkStatus();
  if (has_journalled(1)) {
    // To a newer journal, where there is one.
    if (auto status = Write({}, journals_.Current().value_or(nullptr)); !status.ok()) return status;
  }
  // What cannot be moved stays in the log, where it is safe.
  file_->CheckpointIfDue().IgnoreError();
  if (!is_snapshot_due()) return absl::OkStatus();
  if (auto status = CheckFile(); !status.ok()) return status;
  const absl::Status status = file_->AppendSnapshot(snapshot(), options_.history);
  if (!status.ok() && !absl::IsResourceExhausted(status)) Abandon();
  return status;
}

void SceneLog::Rest() {
  const auto lock = TryLock();
  if (!lock.owns_lock() || !file_ || !journal_ || is_entered_) return;
  if (!journal_->has_failed() && Clock::now() - last_append_ < kRest) return;
  Write({}, nullptr).IgnoreError();  // later, then
}

absl::StatusOr<std::optional<SnapshotRecord>> SceneLog::SnapshotFor(Revision revision) {
  const auto lock = Lock();
  if (auto status = CheckFile(); !status.ok()) return status;
  return file_->SnapshotFor(revision);
}

absl::StatusOr<std::optional<SnapshotRecord>> SceneLog::SnapshotAfter(Revision after) {
  const auto lock = Lock();
  if (auto status = CheckFile(); !status.ok()) return status;
  return file_->SnapshotAfter(after);
}

absl::StatusOr<HistorySpan> SceneLog::Pin() {
  const auto lock = Lock();
  if (auto status = CheckFile(); !status.ok()) return status;
  auto span = file_->Span();
  if (span.ok()) ++pins_;
  return span;
}

void SceneLog::Unpin() {
  const auto lock = Lock();
  --pins_;
}

absl::StatusOr<std::vector<CommitRecord>> SceneLog::CommitsAfter(Revision after, Revision last,
                                                                 uint64_t max_bytes) {
  const auto lock = Lock();
  if (auto status = CheckFile(); !status.ok()) return status;
  return file_->CommitsAfter(after, last, max_bytes);
}

absl::Status SceneLog::Remove() {
  const auto lock = Lock();
  is_removed_ = true;
  is_in_journal_ = false;
  file_.reset();
  absl::Status removed = directory_.RemoveScene(identity_.scene_id, 0);
  if (journal_ && !removed.ok()) journal_->Keep();
  journal_ = nullptr;
  return removed;
}

absl::Status SceneLog::CheckFile() {
  if (is_removed_) {
    return FieldError(absl::StatusCode::kNotFound, "UNKNOWN_ID", "scene_id",
                      "found a scene that was deleted, need a scene");
  }
  if (!file_) {
    return FieldError(absl::StatusCode::kUnavailable, "STORAGE_FAILED", "scene",
                      "found a disk that failed, need it to work again");
  }
  return journalled_.empty() ? absl::OkStatus() : Write({}, journal_);
}

}  // namespace penumbra
