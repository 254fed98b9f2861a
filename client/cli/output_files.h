// Files that a command writes.
#pragma once

#include <filesystem>
#include <string>

#include "absl/status/status.h"

namespace penumbra {

// Errors  kUnavailable: cannot be written
absl::Status WriteText(const std::filesystem::path& path, const std::string& text);

// Makes the folder with its parents where it is missing, and sees that files can be written in it:
// better found out before the work than after.
//
// Errors  kUnavailable: cannot be written; kFailedPrecondition: not a folder
absl::Status PrepareOutputFolder(const std::filesystem::path& folder);

// The same for the folder that `file` is to lie in, and that it is a file or nothing yet.
//
// Errors  as above; kFailedPrecondition: a folder, a device or a pipe
absl::Status PrepareOutputFile(const std::filesystem::path& file);

}  // namespace penumbra
