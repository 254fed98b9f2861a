#include "server/storage/scene_file.h"

#include <random>
#include <utility>

#include "render/scene/field_error.h"
#include "server/storage/scene_rows.h"

namespace penumbra {
namespace {

// `previous` is the chain before a commit: rows check out by themselves once older ones are gone.
// `journal` is the id of the journal that may have commits after the head; empty: there are none.
constexpr char kSchema[] = R"(
CREATE TABLE scene (
  one INTEGER PRIMARY KEY CHECK (one = 1),
  format INTEGER NOT NULL, id TEXT NOT NULL, incarnation BLOB NOT NULL, owner BLOB NOT NULL,
  head_revision INTEGER NOT NULL, head_chain BLOB NOT NULL, seal BLOB NOT NULL,
  journal BLOB NOT NULL) STRICT;
CREATE TABLE commits (
  revision INTEGER PRIMARY KEY,
  content_hash BLOB NOT NULL, key TEXT NOT NULL, fingerprint BLOB NOT NULL, author TEXT NOT NULL,
  time_ms INTEGER NOT NULL, delta BLOB, delta_hash BLOB NOT NULL, previous BLOB NOT NULL,
  chain BLOB NOT NULL) STRICT;
CREATE TABLE snapshots (
  revision INTEGER PRIMARY KEY,
  content_hash BLOB NOT NULL, chain BLOB NOT NULL, body BLOB NOT NULL, hash BLOB NOT NULL
  ) STRICT;
)";

// Files of format 1 have no `journal`.
constexpr int64_t kFormat = 2;
constexpr char kUpgrade[] = R"(
ALTER TABLE scene ADD COLUMN journal BLOB NOT NULL DEFAULT x'';
UPDATE scene SET format = 2;
)";

// Of 4 KiB; three for a small commit. On the average over all files.
constexpr int kCheckpointPages = 200;

std::minstd_rand& Random() {
  static thread_local std::minstd_rand random(std::random_device{}());
  return random;
}

absl::Status CreateTables(Database& database, const SceneIdentity& identity) {
  if (auto status = database.Execute(kSchema); !status.ok()) return status;
  auto insert = database.Prepare(
      "INSERT INTO scene VALUES (1, ?, ?, ?, ?, 0, zeroblob(32), zeroblob(32), x'')");
  if (!insert.ok()) return insert.status();
  insert->Bind(1, kFormat);
  insert->BindText(2, identity.scene_id);
  insert->BindBlob(3, identity.incarnation);
  insert->BindBlob(4, identity.owner);
  return insert->Run();
}

}  // namespace

SceneFile::SceneFile(Database database)
    : database_(std::move(database)),
      checkpoint_pages_(std::uniform_int_distribution<int>(
          kCheckpointPages / 2, kCheckpointPages + kCheckpointPages / 2)(Random())) {}

absl::StatusOr<std::unique_ptr<SceneFile>> SceneFile::Create(const std::string& path,
                                                             const SceneIdentity& identity,
                                                             const DatabaseOptions& options,
                                                             const SceneState& start) {
  absl::Status made = MakeDatabase(path, options, [&](Database& database) {
    SceneFile file(std::move(database));
    file.identity_ = identity;
    absl::Status begun = file.Begin(start);
    database = std::move(file.database_);
    return begun;
  });
  if (!made.ok()) return made;
  return Open(path, options);
}

absl::Status SceneFile::Begin(const SceneState& start) {
  auto transaction = Transaction::Begin(database_);
  if (!transaction.ok()) return transaction.status();
  if (auto status = CreateTables(database_, identity_); !status.ok()) return status;
  SceneHead head{.revision = 0, .chain = FirstChain(identity_)};
  for (const CommitRecord& answer : start.answers) {
    if (auto status = Insert(answer, /*with_delta=*/false, head); !status.ok()) return status;
  }
  if (start.snapshot) {
    head.revision = start.snapshot->revision;
    if (auto status = Insert(*start.snapshot, head.chain); !status.ok()) return status;
  }
  for (const CommitRecord& commit : start.commits) {
    if (auto status = Insert(commit, /*with_delta=*/true, head); !status.ok()) return status;
  }
  if (auto status = WriteHead(head, /*journal=*/""); !status.ok()) return status;
  return transaction->Commit();
}

absl::StatusOr<std::unique_ptr<SceneFile>> SceneFile::Open(const std::string& path,
                                                           const DatabaseOptions& options) {
  // Before SQLite looks at it and takes what it cannot read for never written.
  const auto log = CheckWalFile(path + "-wal");
  if (!log.ok()) return log.status();
  if (*log == WalState::kDamaged) return Damaged("a log with transactions missing");
  auto database = Database::Open(path, {.create = false, .vfs = options.vfs});
  if (!database.ok()) return database.status();
  std::unique_ptr<SceneFile> file(new SceneFile(*std::move(database)));
  file->had_torn_tail_ = *log == WalState::kTornTail;
  if (auto status = file->Verify(); !status.ok()) return status;
  if (auto status = file->CountSinceSnapshot(); !status.ok()) return status;
  return file;
}

absl::StatusOr<std::string> SceneFile::NamedJournal(const std::string& path,
                                                    const DatabaseOptions& options) {
  const auto log = CheckWalFile(path + "-wal");
  if (!log.ok()) return log.status();
  // The transactions that are missing may have named another.
  if (*log == WalState::kDamaged) return Damaged("a log with transactions missing");
  auto database = Database::Open(path, {.create = false, .vfs = options.vfs});
  if (!database.ok()) return database.status();
  SceneFile file(*std::move(database));
  if (auto status = file.ReadIdentity(); !status.ok()) return status;
  return file.journal_;
}

absl::Status SceneFile::Verify() {
  if (auto status = database_.Check(); !status.ok()) return status;
  if (auto status = ReadIdentity(); !status.ok()) return status;
  if (auto status = VerifySnapshots(); !status.ok()) return status;
  return VerifyCommits();
}

absl::Status SceneFile::ReadIdentity() {
  auto format = database_.Prepare("SELECT format FROM scene");
  if (!format.ok()) return format.status();
  const auto is_there = format->Step();
  if (!is_there.ok()) return is_there.status();
  if (!*is_there) return Damaged("no scene");
  format_ = format->Integer(0);
  if (format_ > kFormat) {
    return FieldError(absl::StatusCode::kFailedPrecondition, "NEWER_FORMAT", "format",
                      "found " + std::to_string(format_) + ", need at most " +
                          std::to_string(kFormat) + ": a newer server wrote it");
  }
  auto row = database_.Prepare(
      std::string("SELECT id, incarnation, owner, head_revision, head_chain, seal, ") +
      (format_ == 1 ? "x''" : "journal") + " FROM scene");
  if (!row.ok()) return row.status();
  if (const auto found = row->Step(); !found.ok()) return found.status();
  identity_ = {.scene_id = std::string(row->Text(0)),
               .incarnation = std::string(row->Blob(1)),
               .owner = std::string(row->Blob(2))};
  const auto chain = HashIn(*row, 4);
  const auto seal = HashIn(*row, 5);
  if (!chain.ok() || !seal.ok()) return Damaged("hashes of another length");
  head_ = {.revision = static_cast<Revision>(row->Integer(3)), .chain = *chain};
  journal_ = std::string(row->Blob(6));
  if (format_ < 1 || *seal != SealOf(identity_, head_, journal_)) {
    return Damaged("a seal that does not fit");
  }
  return absl::OkStatus();
}

absl::Status SceneFile::VerifySnapshots() {
  auto rows = database_.Prepare("SELECT revision, content_hash, body, hash, chain FROM snapshots");
  if (!rows.ok()) return rows.status();
  return ForEachRow(*rows, [&](const Statement& row) -> absl::Status {
    const auto snapshot = SnapshotIn(row);
    if (!snapshot.ok()) return snapshot.status();
    const Revision revision = snapshot->revision;
    const auto hash = HashIn(row, 3), snapshot_chain = HashIn(row, 4);
    if (!hash.ok() || !snapshot_chain.ok()) return Damaged("hashes of another length");
    if (HashOf(*snapshot) != *hash) return Damaged("a snapshot that does not fit its hash");
    // The commit of that revision may be forgotten, but then the next one knows.
    auto chain = database_.Prepare(
        "SELECT chain FROM commits WHERE revision = ?1 UNION ALL "
        "SELECT previous FROM commits WHERE revision = ?1 + 1");
    if (!chain.ok()) return chain.status();
    chain->Bind(1, revision);
    const bool is_head = revision == head_.revision;
    if (is_head && *snapshot_chain != head_.chain) return Damaged("a snapshot of another scene");
    size_t known = is_head;
    if (auto status = ForEachRow(*chain,
                                 [&](const Statement& other) {
                                   ++known;
                                   return other.Blob(0) == BytesOf(*snapshot_chain)
                                              ? absl::OkStatus()
                                              : Damaged("a snapshot of another scene");
                                 });
        !status.ok()) {
      return status;
    }
    return known > 0 ? absl::OkStatus() : Damaged("a snapshot without commits after it");
  });
}

absl::Status SceneFile::VerifyCommits() {
  const auto oldest = OldestRevision();
  if (!oldest.ok()) return oldest.status();
  Revision last = *oldest;  // with everything up to it accounted for
  std::optional<Revision> row_before;
  std::optional<ContentHash> chain_before;
  auto rows = database_.Prepare(std::string("SELECT ") + kChainedColumns +
                                " FROM commits ORDER BY revision");
  if (!rows.ok()) return rows.status();
  absl::Status status = ForEachRow(*rows, [&](const Statement& row) -> absl::Status {
    const auto checked = ChainedCommitIn(row);
    if (!checked.ok()) return checked.status();
    const CommitRecord& commit = checked->commit;
    const bool follows = row_before && *row_before + 1 == commit.revision;
    if (follows && *chain_before != checked->link.previous)
      return Damaged("commits of two histories");
    if (commit.revision == 1 && checked->link.previous != FirstChain(identity_)) {
      return Damaged("a first commit of another scene");
    }
    if (commit.revision > *oldest) {
      if (commit.revision != last + 1 || row.IsNull(6)) return Damaged("a commit missing");
      last = commit.revision;
    }
    row_before = commit.revision;
    chain_before = checked->link.chain;
    return absl::OkStatus();
  });
  if (!status.ok()) return status;
  // Answers alone may end before a snapshot that is the head.
  const bool ends_early = row_before && *row_before != head_.revision && *oldest != head_.revision;
  if (last != head_.revision || ends_early) {
    return Damaged("another number of commits than it says");
  }
  if (chain_before && *chain_before != head_.chain) return Damaged("a head of another history");
  if (!row_before && *oldest == 0 && head_.chain != FirstChain(identity_)) {
    return Damaged("a head without commits");
  }
  return absl::OkStatus();
}

absl::Status SceneFile::Upgrade() {
  if (format_ == kFormat) return absl::OkStatus();
  auto transaction = Transaction::Begin(database_);
  if (!transaction.ok()) return transaction.status();
  if (auto status = database_.Execute(kUpgrade); !status.ok()) return status;
  if (auto status = transaction->Commit(); !status.ok()) return status;
  format_ = kFormat;
  return absl::OkStatus();
}

absl::Status SceneFile::CountSinceSnapshot() {
  auto count = database_.Prepare(
      "SELECT count(*), coalesce(sum(length(delta)), 0) FROM commits "
      "WHERE revision > (SELECT coalesce(max(revision), 0) FROM snapshots)");
  if (!count.ok()) return count.status();
  if (const auto row = count->Step(); !row.ok()) return row.status();
  commits_since_ = static_cast<uint64_t>(count->Integer(0));
  bytes_since_ = static_cast<uint64_t>(count->Integer(1));
  auto size =
      database_.Prepare("SELECT length(body) FROM snapshots ORDER BY revision DESC LIMIT 1");
  if (!size.ok()) return size.status();
  const auto row = size->Step();
  if (!row.ok()) return row.status();
  snapshot_bytes_ = *row ? static_cast<uint64_t>(size->Integer(0)) : 0;
  return absl::OkStatus();
}

}  // namespace penumbra
