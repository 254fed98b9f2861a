#include "tests/support/faulty_vfs.h"

#include <chrono>
#include <cstring>
#include <new>
#include <string>
#include <thread>

namespace penumbra::testing {
namespace {

constexpr char kName[] = "faulty";

FaultyVfs* current = nullptr;
sqlite3_vfs* system_vfs = nullptr;
sqlite3_vfs faulty_vfs;

// A file of the system's with ours around it.
struct File {
  sqlite3_file base;
  sqlite3_file* inner;  // behind this struct
  const char* path;     // SQLite's, as long as the file is open; null: a temporary file
};

sqlite3_file* InnerOf(sqlite3_file* file) { return reinterpret_cast<File*>(file)->inner; }

// Who is to be told of what happens to a file; null: nobody. What comes after a first failure is
// not tried on the disk any more.
DiskImage* DiskOf(sqlite3_file* file) {
  const bool is_named = reinterpret_cast<File*>(file)->path != nullptr;
  return current && is_named && current->failures() == 0 ? current->disk() : nullptr;
}
const char* PathOf(sqlite3_file* file) { return reinterpret_cast<File*>(file)->path; }

int Permit(FaultyVfs::Call kind, const char* path) {
  return current ? current->Permit(kind, path) : SQLITE_OK;
}

int Close(sqlite3_file* file) { return InnerOf(file)->pMethods->xClose(InnerOf(file)); }
int Read(sqlite3_file* file, void* out, int size, sqlite3_int64 at) {
  return InnerOf(file)->pMethods->xRead(InnerOf(file), out, size, at);
}
// What fails may have been begun: the disk hears of it in any case.
int Write(sqlite3_file* file, const void* data, int size, sqlite3_int64 at) {
  if (DiskImage* disk = DiskOf(file)) {
    disk->OnWrite(PathOf(file), static_cast<uint64_t>(at),
                  std::string(static_cast<const char*>(data), static_cast<size_t>(size)));
  }
  if (const int code = Permit(FaultyVfs::Call::kWrite, PathOf(file)); code != SQLITE_OK)
    return code;
  return InnerOf(file)->pMethods->xWrite(InnerOf(file), data, size, at);
}
int Truncate(sqlite3_file* file, sqlite3_int64 size) {
  if (DiskImage* disk = DiskOf(file)) disk->OnTruncate(PathOf(file), static_cast<uint64_t>(size));
  if (const int code = Permit(FaultyVfs::Call::kWrite, PathOf(file)); code != SQLITE_OK)
    return code;
  return InnerOf(file)->pMethods->xTruncate(InnerOf(file), size);
}
int Sync(sqlite3_file* file, int flags) {
  if (const int code = Permit(FaultyVfs::Call::kSync, PathOf(file)); code != SQLITE_OK) return code;
  DiskImage* disk = DiskOf(file);
  if (!disk) return InnerOf(file)->pMethods->xSync(InnerOf(file), flags);
  disk->OnSync(PathOf(file));
  return SQLITE_OK;
}
int FileSize(sqlite3_file* file, sqlite3_int64* size) {
  return InnerOf(file)->pMethods->xFileSize(InnerOf(file), size);
}
int Lock(sqlite3_file* file, int kind) {
  return InnerOf(file)->pMethods->xLock(InnerOf(file), kind);
}
int Unlock(sqlite3_file* file, int kind) {
  return InnerOf(file)->pMethods->xUnlock(InnerOf(file), kind);
}
int CheckReservedLock(sqlite3_file* file, int* is_reserved) {
  return InnerOf(file)->pMethods->xCheckReservedLock(InnerOf(file), is_reserved);
}
int FileControl(sqlite3_file* file, int operation, void* argument) {
  return InnerOf(file)->pMethods->xFileControl(InnerOf(file), operation, argument);
}
int SectorSize(sqlite3_file* file) { return InnerOf(file)->pMethods->xSectorSize(InnerOf(file)); }
int DeviceCharacteristics(sqlite3_file* file) {
  return InnerOf(file)->pMethods->xDeviceCharacteristics(InnerOf(file));
}

const sqlite3_io_methods kMethods = {.iVersion = 1,
                                     .xClose = Close,
                                     .xRead = Read,
                                     .xWrite = Write,
                                     .xTruncate = Truncate,
                                     .xSync = Sync,
                                     .xFileSize = FileSize,
                                     .xLock = Lock,
                                     .xUnlock = Unlock,
                                     .xCheckReservedLock = CheckReservedLock,
                                     .xFileControl = FileControl,
                                     .xSectorSize = SectorSize,
                                     .xDeviceCharacteristics = DeviceCharacteristics};

int Open(sqlite3_vfs*, const char* path, sqlite3_file* file, int flags, int* out_flags) {
  auto* ours = new (file) File{};
  ours->inner = reinterpret_cast<sqlite3_file*>(ours + 1);
  ours->path = path;
  const int code = system_vfs->xOpen(system_vfs, path, ours->inner, flags, out_flags);
  if (code != SQLITE_OK) return code;
  ours->base.pMethods = &kMethods;
  if (DiskImage* disk = DiskOf(file)) disk->OnOpen(path);
  return code;
}

int Delete(sqlite3_vfs*, const char* path, int syncs_folder) {
  if (const int code = Permit(FaultyVfs::Call::kDelete, path); code != SQLITE_OK) return code;
  if (current && current->disk()) current->disk()->OnDelete(path, syncs_folder != 0);
  return system_vfs->xDelete(system_vfs, path, syncs_folder);
}

}  // namespace

FaultyVfs::FaultyVfs(DiskImage* disk) : disk_(disk) {
  current = this;
  system_vfs = sqlite3_vfs_find(nullptr);
  faulty_vfs = *system_vfs;
  faulty_vfs.zName = kName;
  faulty_vfs.pNext = nullptr;
  faulty_vfs.szOsFile = static_cast<int>(sizeof(File)) + system_vfs->szOsFile;
  faulty_vfs.xOpen = Open;
  faulty_vfs.xDelete = Delete;
  sqlite3_vfs_register(&faulty_vfs, /*makeDflt=*/0);
}

FaultyVfs::~FaultyVfs() {
  sqlite3_vfs_unregister(&faulty_vfs);
  current = nullptr;
}

const char* FaultyVfs::name() const { return kName; }

void FaultyVfs::FailAfter(int64_t calls, Call kind, int code, const char* part) {
  code_ = code;
  part_ = part;
  left_ = calls;
  failures_ = 0;
  kind_ = kind;
}

void FaultyVfs::Heal() {
  kind_ = Call::kNone;
  is_stalled_ = false;
}

void FaultyVfs::Stall() { is_stalled_ = true; }

int64_t FaultyVfs::failures() const { return failures_; }

int FaultyVfs::Permit(Call kind, const char* path) {
  while (is_stalled_) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  const Call failing = kind_;
  if (failing != kind && failing != Call::kAny) return SQLITE_OK;
  if (std::strstr(path ? path : "", part_) == nullptr) return SQLITE_OK;
  if (--left_ >= 0) return SQLITE_OK;
  ++failures_;
  return code_;
}

}  // namespace penumbra::testing
