#include "server/storage/durable_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "render/scene/field_error.h"

namespace penumbra {
namespace {

struct Descriptor {
  int fd;
  ~Descriptor() {
    if (fd >= 0) ::close(fd);
  }
};

absl::Status WriteAll(int fd, const std::string& path, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(fd, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return FileError(path, errno);
    bytes.remove_prefix(static_cast<size_t>(written));
  }
  return absl::OkStatus();
}

absl::Status WriteAndSync(const std::string& path,
                          const std::function<absl::Status(const Append&)>& write) {
  const Descriptor file{
      ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, 0600)};
  if (file.fd < 0) return FileError(path, errno);
  const absl::Status status =
      write([&](std::string_view bytes) { return WriteAll(file.fd, path, bytes); });
  if (!status.ok()) return status;
  return ::fsync(file.fd) == 0 ? absl::OkStatus() : FileError(path, errno);
}

}  // namespace

absl::Status FileError(const std::string& path, int error_number) {
  const bool is_full = error_number == ENOSPC || error_number == EDQUOT || error_number == EFBIG;
  return FieldError(is_full ? absl::StatusCode::kResourceExhausted : absl::StatusCode::kUnavailable,
                    is_full ? "DISK_FULL" : "STORAGE_FAILED",
                    std::filesystem::path(path).filename().string(),
                    std::string("found '") + std::strerror(error_number) + "', need " +
                        (is_full ? "room on the disk" : "a disk that works"));
}

absl::Status WriteDurably(const std::string& path,
                          const std::function<absl::Status(const Append&)>& write) {
  const std::string beside = path + ".new";
  absl::Status status = WriteAndSync(beside, write);
  if (status.ok() && std::rename(beside.c_str(), path.c_str()) != 0) {
    status = FileError(path, errno);
  }
  if (!status.ok()) {
    ::unlink(beside.c_str());
    return status;
  }
  return SyncFolder(std::filesystem::path(path).parent_path().string());
}

absl::Status WriteDurably(const std::string& path, std::string_view content) {
  return WriteDurably(path, [&](const Append& append) { return append(content); });
}

absl::Status WriteOver(const std::string& path, std::string_view bytes) {
  const Descriptor file{::open(path.c_str(), O_WRONLY | O_CLOEXEC | O_NOFOLLOW)};
  if (file.fd < 0) return FileError(path, errno);
  if (auto status = WriteAll(file.fd, path, bytes); !status.ok()) return status;
  return ::fsync(file.fd) == 0 ? absl::OkStatus() : FileError(path, errno);
}

absl::StatusOr<std::string> ReadFileIfThere(const std::string& path) {
  const Descriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW)};
  if (file.fd < 0) {
    if (errno == ENOENT) return std::string();
    return FileError(path, errno);
  }
  struct stat info {};
  if (::fstat(file.fd, &info) != 0) return FileError(path, errno);
  std::string content(static_cast<size_t>(info.st_size), '\0');
  size_t size = 0;
  while (size < content.size()) {
    const ssize_t count = ::read(file.fd, content.data() + size, content.size() - size);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return FileError(path, errno);
    if (count == 0) break;
    size += static_cast<size_t>(count);
  }
  content.resize(size);
  return content;
}

absl::Status RemoveDurably(const std::string& path) {
  if (::unlink(path.c_str()) != 0) {
    return errno == ENOENT ? absl::OkStatus() : FileError(path, errno);
  }
  return SyncFolder(std::filesystem::path(path).parent_path().string());
}

absl::Status SyncFolder(const std::string& folder) {
  const Descriptor opened{::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)};
  if (opened.fd < 0 || ::fsync(opened.fd) != 0) return FileError(folder, errno);
  return absl::OkStatus();
}

}  // namespace penumbra
