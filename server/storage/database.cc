#include "server/storage/database.h"

#include <sqlite3.h>

#include <filesystem>

#include "render/scene/field_error.h"
#include "server/storage/durable_file.h"

namespace penumbra {
namespace {

// Scenes are many and their transactions small.
constexpr char kPragmas[] =
    "PRAGMA locking_mode = EXCLUSIVE;"  // and with it no shared memory file
    "PRAGMA synchronous = FULL;"
    "PRAGMA cell_size_check = ON;"
    "PRAGMA trusted_schema = OFF;"
    "PRAGMA cache_size = -256;"  // KiB
    "PRAGMA journal_size_limit = 8388608;"
    "PRAGMA journal_mode = WAL;";

// Without the folder, which says more of the machine than clients need to know.
std::string NameOf(sqlite3* database) {
  const char* path = database ? sqlite3_db_filename(database, "main") : nullptr;
  return path ? std::filesystem::path(path).filename().string() : std::string("database");
}

absl::Status ErrorOf(sqlite3* database, int code) {
  const std::string text =
      std::string("found '") + sqlite3_errstr(code) + "' (" + std::to_string(code) + ")";
  const std::string name = NameOf(database);
  switch (code & 0xff) {
    case SQLITE_FULL:
      return FieldError(absl::StatusCode::kResourceExhausted, "DISK_FULL", name,
                        text + ", need room on the disk");
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
    case SQLITE_FORMAT:
    case SQLITE_ERROR:     // a table that is not there, for instance
    case SQLITE_MISMATCH:  // a column of another kind
    case SQLITE_CONSTRAINT:
    case SQLITE_SCHEMA:
      return FieldError(absl::StatusCode::kDataLoss, "DAMAGED", name, text + ", need it sound");
    default:
      return FieldError(absl::StatusCode::kUnavailable, "STORAGE_FAILED", name,
                        text + ", need a disk that works");
  }
}

absl::Status ErrorOf(sqlite3_stmt* statement, int code) {
  sqlite3* database = sqlite3_db_handle(statement);
  return ErrorOf(database,
                 sqlite3_extended_errcode(database) ? sqlite3_extended_errcode(database) : code);
}

}  // namespace

void Statement::Finalize(sqlite3_stmt* statement) { sqlite3_finalize(statement); }

void Statement::Bind(int index, int64_t value) {
  sqlite3_bind_int64(statement_.get(), index, value);
}

void Statement::BindText(int index, std::string_view text) {
  sqlite3_bind_text64(statement_.get(), index, text.data(), text.size(), SQLITE_STATIC,
                      SQLITE_UTF8);
}

void Statement::BindBlob(int index, std::string_view bytes) {
  sqlite3_bind_blob64(statement_.get(), index, bytes.data() ? bytes.data() : "", bytes.size(),
                      SQLITE_STATIC);
}

absl::StatusOr<bool> Statement::Step() {
  const int code = sqlite3_step(statement_.get());
  if (code == SQLITE_ROW) return true;
  if (code == SQLITE_DONE) return false;
  return ErrorOf(statement_.get(), code);
}

absl::Status Statement::Run() {
  const int code = sqlite3_step(statement_.get());
  const absl::Status status = code == SQLITE_DONE || code == SQLITE_ROW
                                  ? absl::OkStatus()
                                  : ErrorOf(statement_.get(), code);
  sqlite3_reset(statement_.get());
  sqlite3_clear_bindings(statement_.get());
  return status;
}

int64_t Statement::Integer(int column) const {
  return sqlite3_column_int64(statement_.get(), column);
}

std::string_view Statement::Text(int column) const {
  const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(statement_.get(), column));
  return {text ? text : "", static_cast<size_t>(sqlite3_column_bytes(statement_.get(), column))};
}

std::string_view Statement::Blob(int column) const {
  const auto* bytes = static_cast<const char*>(sqlite3_column_blob(statement_.get(), column));
  return {bytes ? bytes : "", static_cast<size_t>(sqlite3_column_bytes(statement_.get(), column))};
}

bool Statement::IsNull(int column) const {
  return sqlite3_column_type(statement_.get(), column) == SQLITE_NULL;
}

void Database::Close(sqlite3* database) { sqlite3_close_v2(database); }

absl::StatusOr<Database> Database::Open(const std::string& path, const DatabaseOptions& options) {
  // One thread at a time has a database, so that SQLite need not lock it.
  const int flags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_EXRESCODE |
                    SQLITE_OPEN_NOFOLLOW | (options.create ? SQLITE_OPEN_CREATE : 0);
  sqlite3* opened = nullptr;
  const int code = sqlite3_open_v2(path.c_str(), &opened, flags, options.vfs);
  Database database(opened);
  if (code != SQLITE_OK) return ErrorOf(opened, code);
  if (auto status = database.Configure(); !status.ok()) return status;
  return database;
}

absl::Status Database::Configure() {
  CheckpointOnClose(false);
  sqlite3_db_config(database_.get(), SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  // In the place of SQLite's own, which moves everything when a transaction has made the log long:
  // whoever waits for that transaction would wait for it as well.
  sqlite3_wal_hook(
      database_.get(),
      [](void* log_pages, sqlite3*, const char*, int pages) {
        *static_cast<int*>(log_pages) = pages;
        return SQLITE_OK;
      },
      log_pages_.get());
  return Execute(kPragmas);
}

absl::Status Database::Execute(const char* sql) {
  const int code = sqlite3_exec(database_.get(), sql, nullptr, nullptr, nullptr);
  return code == SQLITE_OK ? absl::OkStatus() : ErrorOf(database_.get(), code);
}

absl::StatusOr<Statement> Database::Prepare(std::string_view sql) {
  sqlite3_stmt* prepared = nullptr;
  const int code = sqlite3_prepare_v2(database_.get(), sql.data(), static_cast<int>(sql.size()),
                                      &prepared, nullptr);
  if (code != SQLITE_OK) return ErrorOf(database_.get(), code);
  return Statement(prepared);
}

absl::Status Database::RunPrepared(std::optional<Statement>& statement, const char* sql) {
  if (!statement) {
    auto prepared = Prepare(sql);
    if (!prepared.ok()) return prepared.status();
    statement = *std::move(prepared);
  }
  return statement->Run();
}

absl::Status Database::Check() {
  auto check = Prepare("PRAGMA quick_check(1)");
  if (!check.ok()) return check.status();
  const auto row = check->Step();
  if (!row.ok()) return row.status();
  if (*row && check->Text(0) == "ok") return absl::OkStatus();
  return FieldError(
      absl::StatusCode::kDataLoss, "DAMAGED", NameOf(database_.get()),
      "found '" + std::string(*row ? check->Text(0) : "nothing") + "', need it sound");
}

absl::Status Database::Checkpoint() {
  const int code = sqlite3_wal_checkpoint_v2(database_.get(), nullptr, SQLITE_CHECKPOINT_TRUNCATE,
                                             nullptr, nullptr);
  return code == SQLITE_OK ? absl::OkStatus() : ErrorOf(database_.get(), code);
}

absl::Status Database::CheckpointInPlace() {
  const int code = sqlite3_wal_checkpoint_v2(database_.get(), nullptr, SQLITE_CHECKPOINT_PASSIVE,
                                             nullptr, nullptr);
  return code == SQLITE_OK ? absl::OkStatus() : ErrorOf(database_.get(), code);
}

void Database::CheckpointOnClose(bool does) {
  sqlite3_db_config(database_.get(), SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, does ? 0 : 1, nullptr);
}

absl::Status MakeDatabase(const std::string& path, const DatabaseOptions& options,
                          const std::function<absl::Status(Database&)>& fill) {
  const std::string beside = path + ".new";
  for (const char* suffix : {"", "-wal"}) {
    if (auto status = RemoveDurably(beside + suffix); !status.ok()) return status;
  }
  {
    auto database = Database::Open(beside, {.create = true, .vfs = options.vfs});
    if (!database.ok()) return database.status();
    if (auto status = fill(*database); !status.ok()) return status;
    // The file alone gets the name.
    if (auto status = database->Checkpoint(); !status.ok()) return status;
    database->CheckpointOnClose(true);  // of an empty log, which is then removed
  }
  if (auto status = RemoveDurably(path + "-wal"); !status.ok()) return status;
  std::error_code error;
  std::filesystem::rename(beside, path, error);
  if (error) return FileError(path, error.value());
  return SyncFolder(std::filesystem::path(path).parent_path());
}

absl::StatusOr<Transaction> Transaction::Begin(Database& database) {
  if (auto status = database.RunPrepared(database.statements_.begin, "BEGIN IMMEDIATE");
      !status.ok()) {
    return status;
  }
  return Transaction(database);
}

Transaction::~Transaction() {
  if (database_) database_->Execute("ROLLBACK").IgnoreError();  // SQLite may have done so itself
}

absl::Status Transaction::Commit() {
  const absl::Status status = database_->RunPrepared(database_->statements_.commit, "COMMIT");
  if (status.ok()) database_ = nullptr;
  return status;
}

}  // namespace penumbra
