#include "server/storage/result_files.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <tuple>
#include <utility>
#include <vector>

#include "render/scene/hashed_text.h"
#include "server/storage/durable_file.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;

constexpr char kUnfinished[] = ".new";

// The hash of the rest goes first.
absl::Status WriteSealed(const std::string& path, std::string_view bytes) {
  const ContentHash seal = HashOfBytes(bytes);
  errno = 0;
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file << BytesOf(seal) << bytes;
  file.close();
  return file ? absl::OkStatus() : FileError(path, errno);
}

}  // namespace

absl::StatusOr<std::unique_ptr<ResultFiles>> ResultFiles::Open(const std::string& folder,
                                                               uint64_t max_bytes) {
  if (::mkdir(folder.c_str(), 0700) != 0 && errno != EEXIST) return FileError(folder, errno);
  std::unique_ptr<ResultFiles> files(new ResultFiles(folder, max_bytes));
  if (auto status = files->Find(); !status.ok()) return status;
  return files;
}

absl::Status ResultFiles::Find() {
  std::vector<std::tuple<fs::file_time_type, ContentHash, uint64_t>> found;
  std::error_code error, ignored;
  fs::directory_iterator file(folder_, error);
  for (; !error && file != fs::directory_iterator(); file.increment(error)) {
    const fs::path& path = file->path();
    if (path.extension() == kUnfinished) fs::remove(path, ignored);
    const auto name = ContentHash::FromHex(path.filename().string());
    if (!name || !file->is_regular_file(ignored)) continue;
    found.emplace_back(file->last_write_time(ignored), *name, file->file_size(ignored));
  }
  if (error) return FileError(folder_, error.value());
  std::sort(found.begin(), found.end());
  std::lock_guard lock(mutex_);
  for (const auto& [time, name, bytes] : found) Add(name, bytes);
  Unlink(TakeOut(bytes_ > max_bytes_ ? bytes_ - max_bytes_ : 0));
  return absl::OkStatus();
}

std::optional<std::string> ResultFiles::Read(const ContentHash& name) {
  {
    std::lock_guard lock(mutex_);
    const auto found = by_name_.find(name);
    if (found == by_name_.end()) return std::nullopt;
    files_.splice(files_.begin(), files_, found->second);
  }
  auto bytes = ReadFileIfThere(PathOf(name));
  const size_t seal_bytes = ContentHash{}.bytes.size();
  if (!bytes.ok() || bytes->size() < seal_bytes ||
      BytesOf(HashOfBytes(std::string_view(*bytes).substr(seal_bytes))) !=
          std::string_view(*bytes).substr(0, seal_bytes)) {
    Remove(name);
    return std::nullopt;
  }
  // The next server finds by the time what was used last.
  std::error_code ignored;
  fs::last_write_time(PathOf(name), fs::file_time_type::clock::now(), ignored);
  bytes->erase(0, seal_bytes);
  return *std::move(bytes);
}

absl::Status ResultFiles::Write(const ContentHash& name, std::string_view bytes) {
  const uint64_t size = bytes.size() + name.bytes.size();
  if (size > max_bytes_ / kLargestPart || Contains(name)) return absl::OkStatus();
  Files leaving;
  if (const uint64_t missing = MissingReserve(); missing > 0) {
    {
      std::lock_guard lock(mutex_);
      leaving = TakeOut(missing);
    }
    Unlink(leaving);
    return absl::OkStatus();
  }
  const std::string beside = PathOf(name) + kUnfinished;
  absl::Status status = WriteSealed(beside, bytes);
  if (status.ok() && std::rename(beside.c_str(), PathOf(name).c_str()) != 0) {
    status = FileError(PathOf(name), errno);
  }
  if (!status.ok()) {
    ::unlink(beside.c_str());
    return status;
  }
  {
    std::lock_guard lock(mutex_);
    Add(name, size);
    leaving = TakeOut(bytes_ > max_bytes_ ? bytes_ - max_bytes_ : 0);
  }
  Unlink(leaving);
  return absl::OkStatus();
}

uint64_t ResultFiles::MissingReserve() const {
  std::error_code error;
  const fs::space_info space = fs::space(folder_, error);
  return error || space.available >= kReserve ? 0 : kReserve - space.available;
}

void ResultFiles::Remove(const ContentHash& name) {
  Files leaving;
  {
    std::lock_guard lock(mutex_);
    leaving = TakeOut(name);
  }
  Unlink(leaving);
}

bool ResultFiles::Contains(const ContentHash& name) const {
  std::lock_guard lock(mutex_);
  return by_name_.contains(name);
}

uint64_t ResultFiles::bytes() const {
  std::lock_guard lock(mutex_);
  return bytes_;
}

void ResultFiles::Add(const ContentHash& name, uint64_t bytes) {
  if (by_name_.contains(name)) return;
  files_.push_front({name, bytes});
  by_name_.emplace(name, files_.begin());
  bytes_ += bytes;
}

// As many as take so many bytes, or all.
ResultFiles::Files ResultFiles::TakeOut(uint64_t bytes) {
  Files leaving;
  for (uint64_t taken = 0; taken < bytes && !files_.empty(); taken += leaving.back().bytes) {
    bytes_ -= files_.back().bytes;
    by_name_.erase(files_.back().name);
    leaving.splice(leaving.end(), files_, std::prev(files_.end()));
  }
  return leaving;
}

ResultFiles::Files ResultFiles::TakeOut(const ContentHash& name) {
  Files leaving;
  if (const auto found = by_name_.find(name); found != by_name_.end()) {
    bytes_ -= found->second->bytes;
    leaving.splice(leaving.end(), files_, found->second);
    by_name_.erase(found);
  }
  return leaving;
}

void ResultFiles::Unlink(const Files& files) const {
  for (const File& file : files) ::unlink(PathOf(file.name).c_str());
}

}  // namespace penumbra
