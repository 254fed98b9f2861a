#include "server/data_folder.h"

#include <sys/stat.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "render/scene/field_error.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;

absl::Status Refused(const std::string& text) {
  return FieldError(absl::StatusCode::kInvalidArgument, "DATA_DIR", "data-dir", text);
}

}  // namespace

std::string DefaultDataFolder(const Environment& environment) {
  std::string state = environment("STATE_DIRECTORY");
  if (!state.empty()) {
    state = state.substr(0, state.find(':'));
    // With DynamicUser= it is a link that systemd has made; a server asks for the folder itself.
    std::error_code error;
    const fs::path folder = fs::canonical(state, error);
    return error ? state : folder.string();
  }
  const std::string data = environment("XDG_DATA_HOME");
  if (data.starts_with('/')) return data + "/penumbra";
  const std::string home = environment("HOME");
  return home.starts_with('/') ? home + "/.local/share/penumbra" : "";
}

absl::Status MakeFoldersAround(const std::string& folder) {
  fs::path made;
  for (const fs::path& part : fs::path(folder).parent_path()) {
    made /= part;
    std::error_code error;
    if (fs::is_directory(made, error) || ::mkdir(made.c_str(), 0700) == 0 || errno == EEXIST) {
      continue;
    }
    return FieldError(absl::StatusCode::kUnavailable, "DATA_DIR", "data-dir",
                      "found that " + made.string() + " cannot be made (" + std::strerror(errno) +
                          "), need --data-dir DIR, or --ephemeral to keep scenes in memory alone");
  }
  return absl::OkStatus();
}

absl::Status CheckDataFolder(const std::string& data_dir, bool is_given, bool ephemeral) {
  if (ephemeral && is_given) {
    return Refused("found " + data_dir + " and ephemeral too, need one of them");
  }
  if (!ephemeral && is_given && data_dir.empty()) {
    return Refused("found nothing, need a folder, or --ephemeral to keep scenes in memory alone");
  }
  if (!ephemeral && data_dir.empty()) {
    return Refused(
        "found no folder to keep scenes in and no HOME, need --data-dir DIR, or --ephemeral to "
        "keep them in memory alone");
  }
  return absl::OkStatus();
}

}  // namespace penumbra
