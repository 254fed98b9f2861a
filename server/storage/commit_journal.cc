#include "server/storage/commit_journal.h"

#include <cerrno>
#include <cstdio>
#include <utility>

#include "render/scene/field_error.h"
#include "render/scene/hashed_text.h"
#include "server/storage/durable_file.h"
#include "server/storage/wal_check.h"

namespace penumbra {
namespace {

// `place` counts from 0. Chains tell of scenes and seals of places, so nothing can be taken out or
// moved unseen but at the end.
constexpr char kSchema[] = R"(
CREATE TABLE journal (
  one INTEGER PRIMARY KEY CHECK (one = 1),
  format INTEGER NOT NULL, id BLOB NOT NULL, seal BLOB NOT NULL) STRICT;
CREATE TABLE entries (
  place INTEGER PRIMARY KEY,
  revision INTEGER NOT NULL,
  content_hash BLOB NOT NULL, key TEXT NOT NULL, fingerprint BLOB NOT NULL, author TEXT NOT NULL,
  time_ms INTEGER NOT NULL, delta BLOB NOT NULL, delta_hash BLOB NOT NULL,
  previous BLOB NOT NULL, chain BLOB NOT NULL,
  incarnation BLOB NOT NULL, seal BLOB NOT NULL) STRICT;
)";

constexpr int64_t kFormat = 1;
constexpr uint64_t kPageBytes = 4096;
constexpr size_t kLogHeaderBytes = 32;

ContentHash SealOfJournal(const std::string& id) {
  return HashedText().Add("penumbra journal").Add(id).Hash();
}

ContentHash SealOfEntry(int64_t place, std::string_view incarnation, const ContentHash& chain) {
  return HashedText().Add(static_cast<uint64_t>(place)).Add(incarnation).Add(chain).Hash();
}

absl::Status Begin(Database& database, const std::string& id) {
  auto transaction = Transaction::Begin(database);
  if (!transaction.ok()) return transaction.status();
  if (auto status = database.Execute(kSchema); !status.ok()) return status;
  {
    auto insert = database.Prepare("INSERT INTO journal VALUES (1, ?, ?, ?)");
    if (!insert.ok()) return insert.status();
    const ContentHash seal = SealOfJournal(id);
    insert->Bind(1, kFormat);
    insert->BindBlob(2, id);
    insert->BindBlob(3, BytesOf(seal));
    if (auto status = insert->Run(); !status.ok()) return status;
  }
  return transaction->Commit();
}

absl::StatusOr<std::string> IdIn(Database& database) {
  auto row = database.Prepare("SELECT format, id, seal FROM journal");
  if (!row.ok()) return row.status();
  const auto found = row->Step();
  if (!found.ok()) return found.status();
  if (!*found) return Damaged("no journal");
  if (row->Integer(0) > kFormat) {
    return FieldError(absl::StatusCode::kFailedPrecondition, "NEWER_FORMAT", "format",
                      "found " + std::to_string(row->Integer(0)) + ", need at most " +
                          std::to_string(kFormat) + ": a newer server wrote it");
  }
  std::string id(row->Blob(1));
  const auto seal = HashIn(*row, 2);
  if (!seal.ok() || *seal != SealOfJournal(id)) return Damaged("a seal that does not fit");
  return id;
}

}  // namespace

absl::StatusOr<std::unique_ptr<CommitJournal>> CommitJournal::Create(const std::string& path,
                                                                     const std::string& id,
                                                                     const DatabaseOptions& options,
                                                                     const std::string& spare) {
  absl::Status made =
      MakeDatabase(path, options, [&](Database& database) { return Begin(database, id); });
  if (!made.ok()) return made;
  if (!spare.empty() && std::rename(spare.c_str(), (path + "-wal").c_str()) != 0 &&
      errno != ENOENT) {
    return FileError(path, errno);
  }
  auto database = Database::Open(path, {.create = false, .vfs = options.vfs});
  if (!database.ok()) return database.status();
  // The log keeps its length, and with a transaction that changes something gets a header: one that
  // has frames and no header is damaged.
  for (const char* sql : {"PRAGMA journal_size_limit = -1", "PRAGMA user_version = 1"}) {
    if (auto status = database->Execute(sql); !status.ok()) return status;
  }
  return std::unique_ptr<CommitJournal>(new CommitJournal(id, *std::move(database)));
}

absl::Status SpareLog(const std::string& path, const std::string& spare) {
  const std::string log = path + "-wal";
  // SQLite, and CheckWal, go by the header: without it there are no frames.
  if (auto status = WriteOver(log, std::string(kLogHeaderBytes, '\0')); !status.ok()) return status;
  // The log goes first: nobody looks for one without its journal.
  if (std::rename(log.c_str(), spare.c_str()) != 0) return FileError(log, errno);
  return RemoveDurably(path);
}

absl::Status CommitJournal::Append(const JournalEntries& entries) {
  auto transaction = Transaction::Begin(database_);
  if (!transaction.ok()) return transaction.status();
  int64_t place = place_;
  for (const auto& of_scene : entries) {
    for (const JournalEntry& entry : of_scene) {
      if (auto status = Insert(entry, place++); !status.ok()) return status;
    }
  }
  if (auto status = transaction->Commit(); !status.ok()) return status;
  place_ = place;
  return absl::OkStatus();
}

absl::Status CommitJournal::Insert(const JournalEntry& entry, int64_t place) {
  if (!insert_) {
    auto prepared = database_.Prepare(
        std::string("INSERT INTO entries (") + kChainedColumns +
        ", place, incarnation, seal) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
    if (!prepared.ok()) return prepared.status();
    insert_ = *std::move(prepared);
  }
  const auto& [commit, link] = entry.chained;
  const ContentHash seal = SealOfEntry(place, entry.incarnation, link.chain);
  insert_->Bind(11, place);
  insert_->BindBlob(12, entry.incarnation);
  insert_->BindBlob(13, BytesOf(seal));
  return InsertChained(*insert_, commit, link, /*with_delta=*/true);
}

// Nothing is ever moved from the log into the file.
uint64_t CommitJournal::bytes() const {
  return static_cast<uint64_t>(database_.log_pages()) * kPageBytes;
}

absl::StatusOr<FoundJournal> ReadJournal(const std::string& path, const DatabaseOptions& options) {
  // An incomplete transaction at the end was never acknowledged.
  const auto log = CheckWalFile(path + "-wal");
  if (!log.ok()) return log.status();
  if (*log == WalState::kDamaged) return Damaged("a journal with transactions missing");
  auto database = Database::Open(path, {.create = false, .vfs = options.vfs});
  if (!database.ok()) return database.status();
  if (auto status = database->Check(); !status.ok()) return status;
  auto id = IdIn(*database);
  if (!id.ok()) return id.status();
  FoundJournal found{.id = *std::move(id)};
  auto rows = database->Prepare(std::string("SELECT ") + kChainedColumns +
                                ", place, incarnation, seal FROM entries ORDER BY place");
  if (!rows.ok()) return rows.status();
  int64_t place = 0;
  absl::Status status = ForEachRow(*rows, [&](const Statement& row) -> absl::Status {
    auto chained = ChainedCommitIn(row);
    if (!chained.ok()) return chained.status();
    const std::string incarnation(row.Blob(11));
    const auto seal = HashIn(row, 12);
    if (row.Integer(10) != place || !seal.ok() ||
        *seal != SealOfEntry(place, incarnation, chained->link.chain)) {
      return Damaged("a journal's entry that does not fit its seal");
    }
    ++place;
    found.commits[incarnation].push_back(*std::move(chained));
    return absl::OkStatus();
  });
  if (!status.ok()) return status;
  return found;
}

absl::StatusOr<std::string> ReadJournalId(const std::string& path, const DatabaseOptions& options) {
  auto database = Database::Open(path, {.create = false, .vfs = options.vfs});
  if (!database.ok()) return database.status();
  return IdIn(*database);
}

}  // namespace penumbra
