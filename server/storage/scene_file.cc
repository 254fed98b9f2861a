#include "server/storage/scene_file.h"

#include <filesystem>
#include <utility>

#include "render/scene/field_error.h"
#include "server/storage/durable_file.h"
#include "server/storage/scene_rows.h"

namespace penumbra {
namespace {

// `previous` is the chain before a commit: rows check out by themselves once older ones are gone.
constexpr char kSchema[] = R"(
CREATE TABLE scene (
  one INTEGER PRIMARY KEY CHECK (one = 1),
  format INTEGER NOT NULL, id TEXT NOT NULL, incarnation BLOB NOT NULL, owner BLOB NOT NULL,
  head_revision INTEGER NOT NULL, head_chain BLOB NOT NULL, seal BLOB NOT NULL) STRICT;
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

constexpr int64_t kFormat = 1;

struct ChainedCommit {
  CommitRecord commit;
  ContentHash previous;
  ContentHash chain;
};

// Of a row of all columns of `commits`. Errors  kDataLoss DAMAGED: the row does not fit its hashes
absl::StatusOr<ChainedCommit> CheckedCommit(const Statement& row) {
  auto commit = CommitIn(row);
  if (!commit.ok()) return commit.status();
  const auto delta_hash = HashIn(row, 7), previous = HashIn(row, 8), chain = HashIn(row, 9);
  if (!delta_hash.ok() || !previous.ok() || !chain.ok()) return Damaged("hashes of no length");
  if (*chain != NextChain(*previous, *commit, *delta_hash)) {
    return Damaged("a commit that does not fit its hash");
  }
  if (!row.IsNull(6) && HashOfBytes(commit->delta) != *delta_hash) {
    return Damaged("a delta that does not fit its hash");
  }
  return ChainedCommit{*std::move(commit), *previous, *chain};
}

absl::Status CreateTables(Database& database, const SceneIdentity& identity) {
  if (auto status = database.Execute(kSchema); !status.ok()) return status;
  auto insert =
      database.Prepare("INSERT INTO scene VALUES (1, ?, ?, ?, ?, 0, zeroblob(32), zeroblob(32))");
  if (!insert.ok()) return insert.status();
  insert->Bind(1, kFormat);
  insert->BindText(2, identity.scene_id);
  insert->BindBlob(3, identity.incarnation);
  insert->BindBlob(4, identity.owner);
  return insert->Run();
}

}  // namespace

absl::StatusOr<std::unique_ptr<SceneFile>> SceneFile::Create(const std::string& path,
                                                             const SceneIdentity& identity,
                                                             const DatabaseOptions& options,
                                                             const SceneState& start) {
  const std::string beside = path + ".new";
  for (const char* suffix : {"", "-wal"}) {
    if (auto status = RemoveDurably(beside + suffix); !status.ok()) return status;
  }
  {
    auto database = Database::Open(beside, {.create = true, .vfs = options.vfs});
    if (!database.ok()) return database.status();
    SceneFile file(*std::move(database));
    file.identity_ = identity;
    if (auto status = file.Begin(start); !status.ok()) return status;
    // The file alone gets the name.
    if (auto status = file.database_.Checkpoint(); !status.ok()) return status;
    file.database_.CheckpointOnClose(true);  // of an empty log, which is then removed
  }
  // A log of an earlier file of this name is none of this one's.
  if (auto status = RemoveDurably(path + "-wal"); !status.ok()) return status;
  std::error_code error;
  std::filesystem::rename(beside, path, error);
  if (error) return FileError(path, error.value());
  if (auto status = SyncFolder(std::filesystem::path(path).parent_path()); !status.ok()) {
    return status;
  }
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
  if (auto status = WriteHead(head); !status.ok()) return status;
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

absl::Status SceneFile::Verify() {
  if (auto status = database_.Check(); !status.ok()) return status;
  if (auto status = ReadIdentity(); !status.ok()) return status;
  if (auto status = VerifySnapshots(); !status.ok()) return status;
  return VerifyCommits();
}

absl::Status SceneFile::ReadIdentity() {
  auto row = database_.Prepare(
      "SELECT format, id, incarnation, owner, head_revision, head_chain, seal FROM scene");
  if (!row.ok()) return row.status();
  const auto found = row->Step();
  if (!found.ok()) return found.status();
  if (!*found) return Damaged("no scene");
  if (row->Integer(0) > kFormat) {
    return FieldError(absl::StatusCode::kFailedPrecondition, "NEWER_FORMAT", "format",
                      "found " + std::to_string(row->Integer(0)) + ", need at most " +
                          std::to_string(kFormat) + ": a newer server wrote it");
  }
  identity_ = {.scene_id = std::string(row->Text(1)),
               .incarnation = std::string(row->Blob(2)),
               .owner = std::string(row->Blob(3))};
  const auto chain = HashIn(*row, 5);
  const auto seal = HashIn(*row, 6);
  if (!chain.ok() || !seal.ok()) return Damaged("hashes of another length");
  head_ = {.revision = static_cast<Revision>(row->Integer(4)), .chain = *chain};
  if (row->Integer(0) != kFormat || *seal != SealOf(identity_, head_)) {
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
  auto rows = database_.Prepare(
      "SELECT revision, content_hash, key, fingerprint, author, time_ms, delta, delta_hash, "
      "previous, chain FROM commits ORDER BY revision");
  if (!rows.ok()) return rows.status();
  absl::Status status = ForEachRow(*rows, [&](const Statement& row) -> absl::Status {
    const auto checked = CheckedCommit(row);
    if (!checked.ok()) return checked.status();
    const auto& [commit, previous, chain] = *checked;
    const bool follows = row_before && *row_before + 1 == commit.revision;
    if (follows && *chain_before != previous) return Damaged("commits of two histories");
    if (commit.revision == 1 && previous != FirstChain(identity_)) {
      return Damaged("a first commit of another scene");
    }
    if (commit.revision > *oldest) {
      if (commit.revision != last + 1 || row.IsNull(6)) return Damaged("a commit missing");
      last = commit.revision;
    }
    row_before = commit.revision;
    chain_before = chain;
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
