#include "proto/archive/archive_file_writer.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <random>
#include <string>
#include <system_error>

#include "absl/strings/str_cat.h"
#include "proto/archive/archive_file.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;

// A link may lead to a file that is yet to be made.
fs::path WithoutLinks(fs::path path) {
  constexpr int kMostLinks = 40;  // as many as Linux follows
  std::error_code error;
  for (int i = 0; i < kMostLinks && fs::is_symlink(path, error); ++i) {
    path = path.parent_path() / fs::read_symlink(path, error);
  }
  return path;
}

// A file's new name is on the disk when its folder is.
bool SyncFolderOf(const fs::path& file) {
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  const int fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return false;
  // Some file systems sync no folders, and say so by EINVAL.
  const bool is_synced = ::fsync(fd) == 0 || errno == EINVAL;
  const int found = errno;
  ::close(fd);
  errno = found;
  return is_synced;
}

}  // namespace

ArchiveFileWriter::ArchiveFileWriter(const fs::path& path)
    : path_(path), target_(WithoutLinks(path)), seal_(FirstSeal()) {}

ArchiveFileWriter::~ArchiveFileWriter() {
  if (file_ != nullptr) ::unlink(beside_.c_str());
}

absl::Status ArchiveFileWriter::CannotWrite() const {
  return absl::UnavailableError(absl::StrCat(
      path_.string(),
      ": cannot be written: ", std::generic_category().message(errno == 0 ? EIO : errno)));
}

// With the permissions that a new file of the user's has.
bool ArchiveFileWriter::OpenBeside() {
  constexpr int kTries = 16;
  std::random_device random;
  for (int i = 0; i < kTries; ++i) {
    beside_ = absl::StrCat(target_.string(), ".", absl::Hex(random(), absl::kZeroPad8), ".part");
    const int fd = ::open(beside_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (fd < 0 && errno == EEXIST) continue;
    if (fd < 0) return false;
    file_.reset(::fdopen(fd, "wb"));
    if (file_ == nullptr) ::close(fd);
    return file_ != nullptr;
  }
  return false;
}

bool ArchiveFileWriter::Append(std::string_view bytes) {
  size_bytes_ += bytes.size();
  return std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) == bytes.size();
}

absl::StatusOr<std::unique_ptr<ArchiveFileWriter>> ArchiveFileWriter::Create(const fs::path& path) {
  std::error_code error;
  const fs::file_status found = fs::status(path, error);
  if (fs::exists(found) && !fs::is_regular_file(found)) {
    return absl::FailedPreconditionError(
        absl::StrCat(path.string(), ": found something that is no file, need a file or nothing"));
  }
  std::unique_ptr<ArchiveFileWriter> writer(new ArchiveFileWriter(path));
  errno = 0;
  if (!writer->OpenBeside() || !writer->Append(kArchiveFirstLine)) return writer->CannotWrite();
  return writer;
}

absl::Status ArchiveFileWriter::Write(const v1::ArchiveRecord& record) {
  std::string framed = SizeText(static_cast<uint32_t>(record.ByteSizeLong()));
  record.AppendToString(&framed);
  seal_ = NextSeal(seal_, framed);
  errno = 0;
  return Append(framed) && Append(BytesOf(seal_)) ? absl::OkStatus() : CannotWrite();
}

absl::Status ArchiveFileWriter::Finish() {
  errno = 0;
  if (std::fflush(file_.get()) != 0 || ::fsync(::fileno(file_.get())) != 0) return CannotWrite();
  if (std::rename(beside_.c_str(), target_.c_str()) != 0) return CannotWrite();
  file_.reset();
  return SyncFolderOf(target_) ? absl::OkStatus() : CannotWrite();
}

}  // namespace penumbra
