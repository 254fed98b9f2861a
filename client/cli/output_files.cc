#include "client/cli/output_files.h"

#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <system_error>

#include "absl/strings/str_cat.h"

namespace penumbra {
namespace {

absl::Status CannotWrite(const std::filesystem::path& path, const std::string& why) {
  return absl::UnavailableError(absl::StrCat(path.string(), ": cannot be written: ", why));
}

}  // namespace

absl::Status WriteText(const std::filesystem::path& path, const std::string& text) {
  errno = 0;
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file << text;
  file.close();
  if (file.good()) return absl::OkStatus();
  return CannotWrite(path, std::generic_category().message(errno == 0 ? EIO : errno));
}

absl::Status PrepareOutputFolder(const std::filesystem::path& folder) {
  std::error_code error;
  if (std::filesystem::exists(folder, error) && !std::filesystem::is_directory(folder, error)) {
    return absl::FailedPreconditionError(
        absl::StrCat(folder.string(), ": found a file, need a folder"));
  }
  std::filesystem::create_directories(folder, error);
  if (error) return CannotWrite(folder, error.message());
  if (access(folder.c_str(), W_OK | X_OK) == 0) return absl::OkStatus();
  return CannotWrite(folder, std::generic_category().message(errno));
}

absl::Status PrepareOutputFile(const std::filesystem::path& file) {
  std::error_code error;
  if (std::filesystem::is_directory(file, error)) {
    return absl::FailedPreconditionError(
        absl::StrCat(file.string(), ": found a folder, need a file"));
  }
  // What a command writes takes the place of what is there: a device or a pipe would be gone.
  if (std::filesystem::exists(file, error) && !std::filesystem::is_regular_file(file, error)) {
    return absl::FailedPreconditionError(
        absl::StrCat(file.string(), ": found a device or a pipe, need a file or nothing"));
  }
  const std::filesystem::path folder = file.parent_path();
  return PrepareOutputFolder(folder.empty() ? std::filesystem::path(".") : folder);
}

}  // namespace penumbra
