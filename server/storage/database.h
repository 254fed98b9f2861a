// One SQLite file that this process alone has open, and statements on it. Knows no scenes.
//
//   auto database = Database::Open(path, {.create = true});
//   auto select = database->Prepare("SELECT body FROM snapshots WHERE revision = ?");
//   select->Bind(1, revision);
//   while (true) {
//     auto row = select->Step();
//     if (!row.ok()) return row.status();
//     if (!*row) break;
//     Use(select->Blob(0));
//   }
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"

struct sqlite3;
struct sqlite3_stmt;

namespace penumbra {

// What a row holds is valid until the next Step, Reset or end of the statement.
class Statement {
 public:
  explicit Statement(sqlite3_stmt* statement) : statement_(statement, &Finalize) {}

  // `index` counts from 1. Text and bytes have to live until the statement is reset.
  void Bind(int index, int64_t value);
  void Bind(int index, uint64_t value) { Bind(index, static_cast<int64_t>(value)); }
  void BindText(int index, std::string_view text);
  void BindBlob(int index, std::string_view bytes);

  // True: there is a row; false: there is none any more. Errors  those of Database
  absl::StatusOr<bool> Step();
  // Runs what gives no rows, and makes it ready to be run again. Errors  those of Database
  absl::Status Run();

  // `column` counts from 0.
  int64_t Integer(int column) const;
  std::string_view Text(int column) const;
  std::string_view Blob(int column) const;
  bool IsNull(int column) const;

 private:
  static void Finalize(sqlite3_stmt* statement);

  std::unique_ptr<sqlite3_stmt, void (*)(sqlite3_stmt*)> statement_;
};

struct DatabaseOptions {
  bool create = false;        // make the file where there is none
  const char* vfs = nullptr;  // SQLite's file system of that name; null: the system's. For tests.
};

class Database {
 public:
  // In write-ahead mode, each transaction synced before it counts as committed, locked against
  // other processes. Nothing is moved from the log into the file when it is closed, until
  // CheckpointOnClose: a file that turns out to be damaged stays as it is.
  //
  // Errors, also of everything else here  kDataLoss DAMAGED: it is no database or a damaged one;
  //   kResourceExhausted DISK_FULL; kUnavailable STORAGE_FAILED: the system reports an error, or
  //   another process has it
  static absl::StatusOr<Database> Open(const std::string& path, const DatabaseOptions& options);

  absl::Status Execute(const char* sql);
  absl::StatusOr<Statement> Prepare(std::string_view sql);
  // Whether the structure of the whole file is sound. Errors  kDataLoss DAMAGED: it is not
  absl::Status Check();
  // Moves everything from the log into the file, now or when it is closed. Nothing else does.
  absl::Status Checkpoint();
  // The same, but the log keeps its length, which later transactions use again: on most file
  // systems writing over is synced sooner than growing.
  absl::Status CheckpointInPlace();
  // Of the log, with what has been moved since it was last written from its beginning.
  int log_pages() const { return *log_pages_; }
  void CheckpointOnClose(bool does);

 private:
  friend class Transaction;
  explicit Database(sqlite3* database) : database_(database, &Close) {}
  static void Close(sqlite3* database);
  absl::Status Configure();

  // What every transaction takes; none: not used yet. They end before the database does.
  absl::Status RunPrepared(std::optional<Statement>& statement, const char* sql);
  struct TransactionStatements {
    std::optional<Statement> begin, commit;
  };

  std::unique_ptr<int> log_pages_ = std::make_unique<int>(0);  // SQLite keeps its address
  std::unique_ptr<sqlite3, void (*)(sqlite3*)> database_;
  TransactionStatements statements_;
};

// Makes a database that is there at once whole, with what `fill` writes: under another name first.
// There is none of this name; a log of an earlier one is removed.
//
// Errors  those of Database, and of `fill`; then there is none
absl::Status MakeDatabase(const std::string& path, const DatabaseOptions& options,
                          const std::function<absl::Status(Database&)>& fill);

// Rolls back what it has begun unless it is committed.
class Transaction {
 public:
  static absl::StatusOr<Transaction> Begin(Database& database);
  ~Transaction();
  Transaction(Transaction&& other) noexcept : database_(other.database_) {
    other.database_ = nullptr;
  }

  // Returns once everything is on disk.
  absl::Status Commit();

 private:
  explicit Transaction(Database& database) : database_(&database) {}
  Database* database_;  // null: over
};

}  // namespace penumbra
