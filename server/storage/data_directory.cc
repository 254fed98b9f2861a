#include "server/storage/data_directory.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>

#include "absl/strings/escaping.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "render/scene/field_error.h"
#include "server/random_bytes.h"
#include "server/storage/durable_file.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;

constexpr char kFormatName[] = "penumbra-data";
constexpr int kFormat = 1;
constexpr char kDatabaseSuffix[] = ".db";
constexpr const char* kFileSuffixes[] = {"", "-wal"};
constexpr char kUnfinished[] = ".db.import";

absl::Status Refused(const char* reason, const std::string& path, const std::string& found,
                     const char* need) {
  return FieldError(absl::StatusCode::kFailedPrecondition, reason, "data-dir",
                    absl::StrCat("found ", path, " ", found, ", need ", need));
}

absl::Status CheckFolder(const std::string& path) {
  struct stat info {};
  if (::lstat(path.c_str(), &info) != 0) {
    if (errno != ENOENT || ::mkdir(path.c_str(), 0700) != 0) {
      return Refused("DATA_DIR", path, absl::StrCat("which is not there: ", std::strerror(errno)),
                     "a folder, or one to make it in");
    }
    return SyncFolder(fs::absolute(path).parent_path());
  }
  if (S_ISLNK(info.st_mode))
    return Refused("DATA_DIR", path, "which is a link", "the folder itself");
  if (!S_ISDIR(info.st_mode)) return Refused("DATA_DIR", path, "which is a file", "a folder");
  if (info.st_uid != ::geteuid()) {
    return Refused("DATA_DIR", path, "which another user owns", "a folder of this one");
  }
  if (::access(path.c_str(), R_OK | W_OK | X_OK) != 0) {
    return Refused("DATA_DIR", path, absl::StrCat("where: ", std::strerror(errno)),
                   "a folder to write in");
  }
  return absl::OkStatus();
}

absl::StatusOr<int> Lock(const std::string& path) {
  const std::string file = path + "/LOCK";
  const int lock = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
  if (lock < 0) {
    return Refused("DATA_DIR", path, absl::StrCat("where LOCK: ", std::strerror(errno)),
                   "a folder to write in");
  }
  if (::flock(lock, LOCK_EX | LOCK_NB) == 0) return lock;
  ::close(lock);
  return Refused("DATA_DIR_LOCKED", path, "which another server is running on",
                 "one of its own (--data-dir DIR), or none (--ephemeral: scenes live in memory)");
}

// What `file` has, if it is there, is there as `other` too, and stays when `file` goes. That takes
// room only on file systems without hard links.
absl::Status LinkOrCopy(const std::string& file, const std::string& other) {
  if (::link(file.c_str(), other.c_str()) == 0 || errno == ENOENT) return absl::OkStatus();
  if (errno != EPERM && errno != EOPNOTSUPP && errno != EMLINK) return FileError(file, errno);
  const auto content = ReadFileIfThere(file);
  return content.ok() ? WriteDurably(other, *content) : content.status();
}

}  // namespace

absl::StatusOr<std::unique_ptr<DataDirectory>> DataDirectory::Open(const std::string& path) {
  if (auto status = CheckFolder(path); !status.ok()) return status;
  const auto lock = Lock(path);
  if (!lock.ok()) return lock.status();
  std::unique_ptr<DataDirectory> directory(new DataDirectory(path, *lock));
  if (auto status = directory->Prepare(); !status.ok()) return status;
  return directory;
}

DataDirectory::~DataDirectory() { ::close(lock_); }

absl::Status DataDirectory::Prepare() {
  const std::string format_path = path_ + "/FORMAT";
  const auto format = ReadFileIfThere(format_path);
  if (!format.ok()) return format.status();
  if (format->empty()) {
    for (const auto& entry : fs::directory_iterator(path_)) {
      if (entry.path().filename() == "LOCK" || entry.path().filename() == "FORMAT.new") continue;
      return Refused("DATA_DIR_FOREIGN", path_,
                     "with " + entry.path().filename().string() + " in it and no FORMAT",
                     "an empty folder or one of a server's");
    }
    identity_ = RandomBytes(16);
    if (auto status = WriteDurably(
            format_path,
            absl::StrCat(kFormatName, " ", kFormat, " ", absl::BytesToHexString(identity_), "\n"));
        !status.ok()) {
      return status;
    }
    return MakeFolders();
  }
  char name[32];
  char hex[33];
  int version = 0;
  if (std::sscanf(format->c_str(), "%31s %d %32[0-9a-f]", name, &version, hex) < 3 ||
      std::string_view(name) != kFormatName) {
    return Refused("DATA_DIR_FOREIGN", path_, "whose FORMAT is none of ours", "a server's folder");
  }
  if (version > kFormat) {
    return Refused("NEWER_FORMAT", path_, absl::StrCat("of format ", version),
                   "one of format 1: a newer server wrote it");
  }
  identity_ = absl::HexStringToBytes(hex);
  if (identity_.size() != 16) {
    return Refused("DATA_DIR_FOREIGN", path_, "whose FORMAT is cut", "a server's folder");
  }
  return MakeFolders();
}

absl::Status DataDirectory::MakeFolders() const {
  for (const char* folder : {"/scenes", "/blobs", "/journals"}) {
    const std::string path = path_ + folder;
    if (::mkdir(path.c_str(), 0700) != 0 && errno != EEXIST) return FileError(path, errno);
  }
  if (auto status = SyncFolder(path_); !status.ok()) return status;
  return RemoveUnfinished();
}

absl::Status DataDirectory::RemoveUnfinished() const {
  std::vector<std::string> unfinished;
  std::error_code error;
  fs::directory_iterator entry(path_ + "/scenes", error);
  for (; !error && entry != fs::directory_iterator(); entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    const size_t tilde = name.rfind('~');  // which no id has
    if (name.find(kUnfinished, tilde) == std::string::npos) continue;
    unfinished.push_back(entry->path().string());
  }
  // A folder that cannot be read is told by who looks for scenes in it.
  for (const std::string& path : unfinished) {
    if (auto status = RemoveDurably(path); !status.ok()) return status;
  }
  return absl::OkStatus();
}

std::string DataDirectory::ScenePath(const std::string& scene_id, uint64_t number) const {
  return absl::StrCat(path_, "/scenes/", scene_id, "~", number, kDatabaseSuffix);
}

absl::StatusOr<std::map<std::string, std::vector<uint64_t>>> DataDirectory::AllSceneFiles() const {
  std::map<std::string, std::vector<uint64_t>> files;
  std::error_code error;
  fs::directory_iterator entry(path_ + "/scenes", error);
  for (; !error && entry != fs::directory_iterator(); entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    const size_t tilde = name.rfind('~');  // which no id has
    uint64_t number = 0;
    if (tilde == std::string::npos || !name.ends_with(kDatabaseSuffix) ||
        !absl::SimpleAtoi(name.substr(tilde + 1, name.size() - tilde - 4), &number)) {
      continue;
    }
    files[name.substr(0, tilde)].push_back(number);
  }
  if (error) return FileError(path_ + "/scenes", error.value());
  for (auto& [scene_id, numbers] : files) std::sort(numbers.begin(), numbers.end());
  return files;
}

absl::StatusOr<std::map<std::string, uint64_t>> DataDirectory::SceneFiles() const {
  const auto all = AllSceneFiles();
  if (!all.ok()) return all.status();
  std::map<std::string, uint64_t> newest;
  for (const auto& [scene_id, numbers] : *all) newest[scene_id] = numbers.back();
  return newest;
}

absl::StatusOr<uint64_t> DataDirectory::NextNumber(const std::string& scene_id) const {
  const auto newest = SceneFiles();
  if (!newest.ok()) return newest.status();
  const auto found = newest->find(scene_id);
  return found == newest->end() ? 1 : found->second + 1;
}

std::string DataDirectory::JournalPath(uint64_t number) const {
  return absl::StrCat(path_, "/journals/", number, kDatabaseSuffix);
}

absl::StatusOr<std::vector<uint64_t>> DataDirectory::Journals() const {
  std::vector<uint64_t> numbers;
  std::error_code error;
  fs::directory_iterator entry(path_ + "/journals", error);
  for (; !error && entry != fs::directory_iterator(); entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    uint64_t number = 0;
    if (!name.ends_with(kDatabaseSuffix) ||
        !absl::SimpleAtoi(name.substr(0, name.size() - std::strlen(kDatabaseSuffix)), &number)) {
      continue;
    }
    numbers.push_back(number);
  }
  if (error) return FileError(path_ + "/journals", error.value());
  std::sort(numbers.begin(), numbers.end());
  return numbers;
}

absl::StatusOr<uint64_t> DataDirectory::NextJournal() const {
  const auto numbers = Journals();
  if (!numbers.ok()) return numbers.status();
  return numbers->empty() ? 1 : numbers->back() + 1;
}

absl::Status DataDirectory::RemoveJournal(uint64_t number) const {
  // The log first: nobody looks for one without its journal.
  if (auto status = RemoveDurably(JournalPath(number) + "-wal"); !status.ok()) return status;
  return RemoveDurably(JournalPath(number));
}

absl::Status DataDirectory::RemoveScene(const std::string& scene_id, uint64_t kept) {
  const auto all = AllSceneFiles();
  if (!all.ok()) return all.status();
  const auto found = all->find(scene_id);
  if (found == all->end()) return absl::OkStatus();
  for (const uint64_t number : found->second) {
    if (number == kept) continue;
    for (const char* suffix : kFileSuffixes) {
      if (auto status = RemoveDurably(ScenePath(scene_id, number) + suffix); !status.ok()) {
        return status;
      }
    }
  }
  return absl::OkStatus();
}

absl::Status DataDirectory::PutAside(const std::string& scene_id,
                                     std::span<const uint64_t> journals) {
  const auto all = AllSceneFiles();
  if (!all.ok()) return all.status();
  const auto found = all->find(scene_id);
  if (found == all->end() && journals.empty()) return absl::OkStatus();
  const std::string folder = path_ + "/removed";
  if (::mkdir(folder.c_str(), 0700) != 0 && errno != EEXIST) return FileError(folder, errno);
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const std::string stem =
      absl::StrCat(folder, "/", std::chrono::duration_cast<std::chrono::microseconds>(now).count(),
                   "-", scene_id, "~");
  for (const uint64_t number : journals) {
    for (const char* suffix : kFileSuffixes) {
      const std::string aside = absl::StrCat(stem, "journal-", number, kDatabaseSuffix, suffix);
      if (auto status = LinkOrCopy(JournalPath(number) + suffix, aside); !status.ok()) {
        return status;
      }
    }
  }
  const auto numbers = found == all->end() ? std::vector<uint64_t>() : found->second;
  for (const uint64_t number : numbers) {
    for (const char* suffix : kFileSuffixes) {
      const std::string file = ScenePath(scene_id, number) + suffix;
      const std::string aside = absl::StrCat(stem, number, kDatabaseSuffix, suffix);
      if (std::rename(file.c_str(), aside.c_str()) != 0 && errno != ENOENT) {
        return FileError(file, errno);
      }
    }
  }
  if (auto status = SyncFolder(folder); !status.ok()) return status;
  return SyncFolder(path_ + "/scenes");
}

}  // namespace penumbra
