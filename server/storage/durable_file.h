// Small files that are either wholly there after a crash or not at all, and folders whose entries
// are.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace penumbra {

// Writes a file beside `path`, has `write` fill it by calls of its argument, syncs it and gives it
// the name `path`, in place of what had it.
//
// Errors, also of the rest  kResourceExhausted DISK_FULL; kUnavailable STORAGE_FAILED
using Append = std::function<absl::Status(std::string_view)>;
absl::Status WriteDurably(const std::string& path,
                          const std::function<absl::Status(const Append&)>& write);
absl::Status WriteDurably(const std::string& path, std::string_view content);

// Writes over the beginning of a file that is there, and syncs it.
absl::Status WriteOver(const std::string& path, std::string_view bytes);

// Empty where there is no such file.
absl::StatusOr<std::string> ReadFileIfThere(const std::string& path);

// Removes the file, if it is there, for good.
absl::Status RemoveDurably(const std::string& path);

// Makes what was created, renamed or removed in a folder last.
absl::Status SyncFolder(const std::string& folder);

// What the system said about `path`.
absl::Status FileError(const std::string& path, int error_number);

}  // namespace penumbra
